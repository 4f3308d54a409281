// Calls that judge a mesh or a result, write it or read it.
#include <algorithm>

#include "golden/calls.hpp"
#include "temp_folder.hpp"

namespace golden {

using lamella::MeshView;
using lamella::SliceResult;

namespace {

std::uint64_t hash_of_ledger(const lamella::Ledger& ledger) {
    Hash hash;
    for (const std::uint64_t count :
         {ledger.triangles, ledger.cut, ledger.between, ledger.degenerate, ledger.horizontal, ledger.shells.count,
          ledger.shells.triangles, ledger.peaks.count, ledger.peaks.triangles, ledger.pits.count, ledger.pits.triangles}) {
        hash.word(count);
    }
    hash.real(ledger.flat_up_mm2).real(ledger.flat_down_mm2);
    for (const lamella::Slab& slab : ledger.slabs) {
        hash.word(slab.layer).word(slab.triangles).real(slab.flat_up_mm2).real(slab.flat_down_mm2);
        hash.word(slab.shells).word(slab.peaks).word(slab.pits);
    }
    for (const lamella::SurfacePiece& piece : ledger.pieces) {
        hash.text(name_of(piece.kind)).word(piece.layer).reals(piece.at_mm).real(piece.height_mm).word(piece.triangles);
    }
    for (const std::uint64_t layer : ledger.gaps) {
        hash.word(layer);
    }
    return hash.value();
}

std::uint64_t hash_of_volume(const lamella::VolumeCertificate& volume) {
    Hash hash;
    hash.text(name_of(volume.verdict)).real(volume.mesh_mm3).real(volume.slabs_mm3).reals(volume.slab_mm3);
    hash.word(volume.worst_layer).real(volume.worst_difference_mm2).real(volume.worst_allowed_mm2);
    return hash.value();
}

std::uint64_t hash_of_crossings(const lamella::Crossings& crossings) {
    Hash hash;
    hash.word(crossings.count).word(crossings.at_least ? 1 : 0);
    for (const lamella::LayerCrossings& layer : crossings.layers) {
        hash.word(layer.layer).word(layer.count).word(layer.at_least ? 1 : 0).integer(layer.first.x).integer(layer.first.y);
        hash.word(layer.contours[0]).word(layer.contours[1]);
    }
    return hash.value();
}

std::uint64_t hash_of_counts(const lamella::MeshCheck& mesh) {
    Hash hash;
    hash.word(mesh.triangles).word(mesh.degenerate).reals(mesh.box.min_mm).reals(mesh.box.max_mm);
    hash.real(mesh.volume_mm3).real(mesh.area_mm2).word(mesh.edges).word(mesh.boundary_edges).word(mesh.overfull_edges);
    hash.word(mesh.mismatched_edges).word(mesh.shell_count).real(mesh.grid_mm).word(mesh.closed ? 1 : 0);
    return hash.value();
}

/// Without the lines of what differs from run to run: "threads", "bands", and the object "ms".
std::string without_times(const std::string& report) {
    std::string left;
    bool in_times = false;
    for (std::size_t at = 0; at < report.size();) {
        const std::size_t end = std::min(report.find('\n', at), report.size() - 1) + 1;
        const std::string line = report.substr(at, end - at);
        in_times = in_times || line.find("\"ms\": {") != std::string::npos;
        if (!in_times && line.find("\"threads\": ") == std::string::npos && line.find("\"bands\": ") == std::string::npos) {
            left += line;
        }
        in_times = in_times && line.find('}') == std::string::npos;
        at = end;
    }
    return left;
}

std::string bytes_written(const TempFolder& folder, const lamella::Status& written, const std::string& name) {
    INFO((written ? std::string() : written.error().message));
    REQUIRE(written.ok());
    return bytes_of(folder / name);
}

std::uint64_t hash_of_file(const lamella::MeshFile& file) {
    Hash hash;
    const MeshView view = file.view();
    const std::size_t number = size_of(view.vertex_type);
    const std::size_t rows = view.indices == nullptr ? view.triangle_count : view.vertex_count;
    const std::size_t row_bytes = number * (view.indices == nullptr ? 9 : 3);
    for (std::size_t row = 0; row < rows; ++row) {
        hash.text({reinterpret_cast<const char*>(view.vertex_at(row)), row_bytes});
    }
    for (const std::uint32_t index : file.indices) {
        hash.word(index);
    }
    hash.text(name_of(file.format)).word(view.triangle_count).word(view.vertex_count).word(number);
    hash.word(file.text ? 1 : 0).word(file.compressed ? 1 : 0).real(file.mm_per_unit).word(file.states_unit ? 1 : 0);
    hash.text(name_of(file.patient_frame)).word(file.warnings.size()).word(file.file_bytes);
    return hash.value();
}

/// Three hashes, the same on 1 and 3 threads.
template <class HashesOn>
void add_three(Group& group, const std::string& name, const std::array<const char*, 3>& what, const HashesOn& hashes_on) {
    const std::array<std::uint64_t, 3> hashes = hashes_on(1);
    CHECK(hashes == hashes_on(3));
    for (std::size_t i = 0; i < 3; ++i) {
        group.output(name + ", " + what[i], hashes[i]);
    }
}

}  // namespace

void add_audit(Group& group, const std::string& name, const MeshView& mesh, const Options& options) {
    const SliceResult result = sliced(mesh, options);
    add_three(group, name, {"ledger", "volume", "crossings"}, [&](int threads) {
        const lamella::Audit found = answer(audit(result, mesh, {}, {.threads = threads}));
        return std::array{hash_of_ledger(*found.ledger), hash_of_volume(*found.volume), hash_of_crossings(*found.crossings)};
    });
}

void add_written(Group& group, const std::string& name, const MeshView& mesh, const Options& options) {
    const SliceResult result = sliced(mesh, options);
    const lamella::Audit found = answer(audit(result, mesh));
    const lamella::WeldedMesh welded = answer(weld(mesh, 0.03125));
    const std::vector<std::string> warnings = {"one \"warning\""};
    using lamella::ReportPlace;
    const std::vector<lamella::ReportMember> members = {
        {ReportPlace::after_mesh, "output", std::string_view("layers.svg")},
        {ReportPlace::after_times, "peak_rss_bytes", std::uint64_t{0}},
        {ReportPlace::at_end, "warnings", std::span<const std::string>(warnings)}};
    lamella::ReportParts parts{.mesh_name = "mesh.stl", .audit = &found, .members = members};
    const std::string report = answer(make_report_json(result, parts));
    CHECK(without_times(report).size() < report.size());
    group.output(name + ", report", hash_of(without_times(report)));
    const TempFolder folder;
    group.output(name + ", SVG", hash_of(bytes_written(folder, write_svg(result, folder / "layers.svg"), "layers.svg")));
    parts.welded = &welded;
    group.output(name + ", report of welding", hash_of(without_times(answer(make_report_json(result, parts)))));
    group.output(
        name + ", SVG of welding",
        hash_of(bytes_written(folder, write_svg(result, folder / "layers.svg", {.welded = &welded}), "layers.svg")));
}

void add_check(Group& group, const std::string& name, const MeshView& mesh) {
    add_three(group, name, {"inspected", "check", "marks"}, [&](int threads) {
        const lamella::Context context{.threads = threads};
        const lamella::MeshCheck found = answer(check(mesh, {.tolerance_mm = 0.0625, .most_places = 40}, context));
        const lamella::ReportMember no_warnings{.key = "warnings", .value = std::span<const std::string>()};
        const lamella::ReportParts parts{.mesh_name = "mesh.stl", .members = {&no_warnings, 1}};
        const TempFolder folder;
        return std::array{hash_of_counts(answer(check(mesh, {.counts_only = true}, context))),
                          hash_of(answer(make_check_json(found, parts, 30))),
                          hash_of(bytes_written(folder, write_marks(found, folder / "marks.ply"), "marks.ply"))};
    });
}

lamella::Segment segment(std::uint64_t from_key, std::uint64_t to_key, std::array<std::int32_t, 2> from,
                         std::array<std::int32_t, 2> to, std::uint32_t from_rank, std::uint32_t to_rank) {
    return {{from_key, 0, 0}, {to_key, 0, 0}, {from[0], from[1]}, {to[0], to[1]}, from_rank, to_rank};
}

void add_assembled(Group& group, const std::string& name, const Segments& segments) {
    const SliceResult layer = answer(assemble(segments));
    Hash hash;
    add_contours(hash, layer.contours.span(), layer.points.span());
    group.output(name, hash.value());
}

void add_read(Group& group, const std::string& name, const std::filesystem::path& path) {
    std::vector<std::uint64_t> hashes;
    for (const bool map : {false, true}) {
        for (const int threads : {1, 3}) {
            hashes.push_back(
                hash_of_file(answer(lamella::read_mesh(path, {.map_file = map, .mm_per_unit = 0.5}, {.threads = threads}))));
        }
    }
    INFO(name);
    CHECK(std::count(hashes.begin(), hashes.end(), hashes.front()) == 4);
    group.output(name, hashes.front());
}

}  // namespace golden
