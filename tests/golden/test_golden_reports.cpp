// Judgements of a mesh or a result, files written of it, and contours from segments.
#include <sstream>

#include <catch2/catch.hpp>

#include "golden/golden.hpp"
#include "lamella/io.hpp"
#include "temp_folder.hpp"

using namespace lamella;

namespace golden {

namespace {

using Segments = std::vector<Segment>;

/// Without the lines of what differs from run to run: "threads", "bands", and the object "ms".
std::string without_times(const std::string& report) {
    std::string kept;
    bool in_times = false;
    std::istringstream lines(report);
    for (std::string line; std::getline(lines, line);) {
        const auto has = [&](const char* text) { return line.find(text) != std::string::npos; };
        in_times = in_times || has("\"ms\": {");
        if (!in_times && !has("\"threads\": ") && !has("\"bands\": ")) {
            kept += line + "\n";
        }
        in_times = in_times && !has("}");
    }
    return kept;
}

std::string bytes_written(const TempFolder& folder, const Status& written, const std::string& name) {
    require_ok(written);
    return bytes_of(folder / name);
}

/// Three hashes, the same on 1 and 3 threads.
template <class HashesOn>
void add_three(Hashes& hashes, const std::string& name, const std::array<const char*, 3>& what, const HashesOn& hashes_on) {
    const std::array<std::uint64_t, 3> found = hashes_on(1);
    CHECK(found == hashes_on(3));
    for (std::size_t i = 0; i < 3; ++i) {
        add(hashes, name + ", " + what[i], found[i]);
    }
}

void add_audit(Hashes& hashes, const std::string& name, const MeshView& mesh, const Options& options) {
    const SliceResult result = sliced(mesh, options);
    add_three(hashes, name, {"ledger", "volume", "crossings"}, [&](int threads) {
        const Audit found = value_of(audit(result, mesh, {}, {.threads = threads}));
        return std::array{hash_of(*found.ledger), hash_of(*found.volume), hash_of(*found.crossings)};
    });
}

void add_written(Hashes& hashes, const std::string& name, const MeshView& mesh, const Options& options) {
    const SliceResult result = sliced(mesh, options);
    const Audit found = value_of(audit(result, mesh));
    const WeldedMesh welded = value_of(weld(mesh, 0.03125));
    const std::vector<std::string> warnings = {"one \"warning\""};
    const std::vector<ReportMember> members = {{ReportPlace::after_mesh, "output", std::string_view("layers.svg")},
                                               {ReportPlace::after_times, "peak_rss_bytes", std::uint64_t{0}},
                                               {ReportPlace::at_end, "warnings", std::span<const std::string>(warnings)}};
    ReportParts parts{.mesh_name = "mesh.stl", .audit = &found, .members = members};
    const std::string report = value_of(make_report_json(result, parts));
    CHECK(without_times(report).size() < report.size());
    add(hashes, name + ", report", hash_of(without_times(report)));
    const TempFolder folder;
    add(hashes, name + ", SVG",
        hash_of(bytes_written(folder, done(write_layers(result, folder / "layers.svg")), "layers.svg")));
    parts.welded = &welded;
    add(hashes, name + ", report of welding", hash_of(without_times(value_of(make_report_json(result, parts)))));
    add(hashes, name + ", SVG of welding",
        hash_of(
            bytes_written(folder, done(write_layers(result, folder / "layers.svg", {.welded = &welded})), "layers.svg")));
}

/// The counts, the JSON and the PLY of faults.
void add_check(Hashes& hashes, const std::string& name, const MeshView& mesh) {
    add_three(hashes, name, {"inspected", "check", "marks"}, [&](int threads) {
        const Context context{.threads = threads};
        const MeshCheck found = value_of(check(mesh, {.tolerance_mm = 0.0625, .most_places = 40}, context));
        const ReportMember no_warnings{.key = "warnings", .value = std::span<const std::string>()};
        const ReportParts parts{.mesh_name = "mesh.stl", .members = {&no_warnings, 1}};
        const TempFolder folder;
        return std::array{hash_of(value_of(check(mesh, {.counts_only = true}, context))),
                          hash_of(value_of(make_check_json(found, parts, 30))),
                          hash_of(bytes_written(folder, write_marks(found, folder / "marks.ply"), "marks.ply"))};
    });
}

/// "NAME, welded" and the slices of the outcome.
void add_weld(Hashes& hashes, const std::string& name, const MeshView& mesh, double tolerance_mm) {
    const WeldedMesh welded = value_of(weld(mesh, tolerance_mm));
    const std::string_view coordinates(reinterpret_cast<const char*>(welded.coordinates.data()), welded.coordinates.size());
    add(hashes, name + ", welded",
        Hash()
            .add(coordinates, welded.indices, static_cast<int>(welded.vertex_type), welded.vertex_count, welded.joined,
                 welded.largest_move_mm)
            .value());
    add_slices(hashes, name + ", slices", welded.view(), uniform(0.375));
}

/// Calls look(name, mesh) for each.
template <class Look>
void each_mesh(const std::vector<std::string>& names, const Look& look) {
    for (const std::string& name : names) {
        const HeldMesh held(mesh(name), Form::f32_soup);
        look(name, held.view());
    }
}

const std::vector<std::string> all_kinds = {
    "voxel body",        "torn body",           "cracked body", "body of mixed senses", "body with degenerate faces",
    "crossing bodies",   "overlapping boxes",   "nested boxes", "checkerboard",         "tetrahedra",
    "lattice triangles", "self-crossing prisms"};

/// Squares within squares, every third one clockwise.
Segments nested_squares() {
    Segments segments;
    for (std::int32_t i = 0; i < 40; ++i) {
        const std::int32_t a = 3 * i;
        const std::int32_t b = 400 - 3 * i;
        const bool backwards = i % 3 == 1;
        const Point corners[] = {
            {a, a}, {backwards ? a : b, backwards ? b : a}, {b, b}, {backwards ? b : a, backwards ? a : b}};
        for (std::uint64_t corner = 0; corner < 4; ++corner) {
            const std::uint64_t first = 4 * static_cast<std::uint64_t>(i);
            const std::uint64_t next = (corner + 1) % 4;
            segments.push_back({{first + corner, 0, 0}, {first + next, 0, 0}, corners[corner], corners[next], 0, 0});
        }
    }
    return segments;
}

/// Segments between random points of a lattice, so that many meet at a key, some both ways, and some at no other.
Segments random_segments(std::uint64_t seed, int count, int range) {
    models::Random random(seed);
    const auto drawn = [&](int end) { return between(random, 0, end); };
    Segments segments(static_cast<std::size_t>(count));
    for (Segment& segment : segments) {
        segment.from.x = drawn(range);
        segment.from.y = drawn(range);
        segment.to.x = drawn(range);
        segment.to.y = drawn(range);
        segment.from_key.a = static_cast<std::uint64_t>(segment.from.x * 1000 + segment.from.y);
        segment.to_key.a = static_cast<std::uint64_t>(segment.to.x * 1000 + segment.to.y);
        segment.from_rank = static_cast<std::uint32_t>(drawn(5));
        segment.to_rank = static_cast<std::uint32_t>(drawn(5));
    }
    return segments;
}

TEST_CASE("welded meshes are those committed", "[golden]") {
    Hashes hashes;
    each_mesh({"voxel body", "cracked body", "lattice triangles"}, [&](const std::string& name, const auto& mesh) {
        add_weld(hashes, name + ", exact", mesh, 0);
        add_weld(hashes, name + ", near", mesh, 0.078125);
        add_weld(hashes, name + ", far", mesh, 1.25);
    });
    each_mesh({"cracked body"}, [&](const std::string& name, const auto&) {
        add_weld(hashes, name + ", doubles", HeldMesh(mesh(name)).view(), 0.078125);
        add_weld(hashes, name + ", indexed", HeldMesh(mesh(name), Form::f64_indexed).view(), 0.078125);
    });
    check_golden("weld", hashes);
}

TEST_CASE("ledgers, certificates and crossings are those committed", "[golden]") {
    Hashes hashes;
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) {
        add_audit(hashes, name, mesh, uniform(0.75));
        add_audit(hashes, name + ", thick layers", mesh, above(uniform(2.5)));
        add_audit(hashes, name + ", turned", mesh, turned(1, 2, 3, uniform(1.5)));
    });
    each_mesh({"crossing bodies", "torn body"}, [&](const std::string& name, const auto& mesh) {
        add_audit(hashes, name + ", non-zero", mesh, filled(Rule::non_zero, uniform(1.5)));
    });
    check_golden("audit", hashes);
}

TEST_CASE("reports and SVG files are those committed", "[golden]") {
    Hashes hashes;
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) { add_written(hashes, name, mesh, uniform(1.5)); });
    each_mesh({"torn body", "tetrahedra"}, [&](const std::string& name, const auto& mesh) {
        add_written(hashes, name + ", explicit", mesh, turned(1, 1, 1, at_heights({-4, 0, 1.5, 3, 10.1}, 0)));
        add_written(hashes, name + ", gaps closed", mesh, filled(Rule::positive, stitched(1, uniform(1.5))));
        add_written(hashes, name + ", coarse grid", mesh,
                    on_grid(0x1p-4, {.layer_height_mm = 1.5, .planes = {.first_height_mm = 0.25, .datum = Datum::zero}}));
    });
    check_golden("written", hashes);
}

TEST_CASE("diagnoses of meshes are those committed", "[golden]") {
    Hashes hashes;
    each_mesh(all_kinds, [&](const std::string& name, const auto& mesh) { add_check(hashes, name, mesh); });
    check_golden("check", hashes);
}

TEST_CASE("contours from segments are those committed", "[golden]") {
    Hashes hashes;
    const std::pair<std::string, Segments> all[] = {{"nested squares", nested_squares()},
                                                    {"few segments on a fine lattice", random_segments(1, 400, 30)},
                                                    {"many segments on a coarse lattice", random_segments(2, 2000, 9)},
                                                    {"a bundle", random_segments(3, 300, 2)}};
    for (const auto& [name, segments] : all) {
        const SliceResult layer = value_of(assemble(segments));
        Hash hash;
        add(hashes, name, add_contours(hash, layer.contours.span(), layer.points.span()).value());
    }
    check_golden("assemble", hashes);
}

}  // namespace
}  // namespace golden
