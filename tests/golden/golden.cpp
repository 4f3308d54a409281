#include "golden/golden.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iomanip>

#include <catch2/catch.hpp>

namespace golden {

using lamella::MeshView;
using lamella::SliceResult;

namespace {

const std::string path = std::string(LAMELLA_TESTS_DIR) + "/golden/hashes.txt";

std::string group_of(const std::string& name) {
    const std::size_t colon = name.find(": ");
    return colon == std::string::npos ? "" : name.substr(0, colon);
}

Hashes read_lines() {
    Hashes lines;
    std::ifstream in(path);
    std::uint64_t hash = 0;
    std::string name;
    while (in >> std::hex >> hash && std::getline(in >> std::ws, name)) {
        lines[name] = hash;
    }
    return lines;
}

void write_lines(const Hashes& lines) {
    std::ofstream out(path);
    for (const auto& [name, hash] : lines) {
        out << std::hex << std::setw(16) << std::setfill('0') << hash << ' ' << name << '\n';
    }
    REQUIRE(out.good());
}

std::uint64_t hash_of_shapes(const SliceResult& result) {
    Hash hash;
    for (const lamella::Layer& layer : result.layers) {
        hash.add(layer.plane.z(), layer.first_contour, layer.contour_count);
    }
    add_contours(hash, result.contours.span(), result.points.span());
    return hash.add(result.hash()).value();
}

/// The area that closed contours enclose, also where that of the layer is not known.
double closed_area(const lamella::LayerView& layer) {
    double twice_area = 0;
    for (const lamella::Contour& contour : layer.contours) {
        twice_area += contour.twice_area.to_double();
    }
    return twice_area / 2 * layer.grid_mm * layer.grid_mm;
}

double length_mm(const lamella::Stitch& stitch, double grid_mm) {
    const double dx = static_cast<double>(stitch.to.x) - stitch.from.x;
    const double dy = static_cast<double>(stitch.to.y) - stitch.from.y;
    return std::sqrt(dx * dx + dy * dy) * grid_mm;
}

std::uint64_t hash_of_numbers(const SliceResult& result) {
    Hash hash;
    const lamella::SliceInfo& info = result.info;
    for (const lamella::LayerView layer : result) {
        hash.add(layer.bottom_mm, layer.plane_mm, layer.top_mm, layer.segments, closed_area(layer));
    }
    for (const lamella::Stitch& stitch : result.stitches) {
        hash.add(stitch.layer, stitch.from, stitch.to, length_mm(stitch, info.grid_mm));
    }
    hash.add(name_of(info.options.region.fill_rule), info.options.stitch_mm, info.grid_mm, info.options.frame.transform.m);
    hash.add(info.triangles, info.degenerate, info.crossed, info.segments, info.holes, info.open_contours,
             info.flat_contours, info.overruled_contours);
    return hash.add(info.box.min_mm, info.box.max_mm).value();
}

}  // namespace

void add(Hashes& hashes, const std::string& name, std::uint64_t hash) {
    INFO(name);
    CHECK(hashes.emplace(name, hash).second);
}

void check_golden(const std::string& group, const Hashes& produced) {
    Hashes lines = read_lines();
    Hashes committed = lines;
    std::erase_if(committed, [&](const auto& line) { return group_of(line.first) != group; });
    Hashes found;
    for (const auto& [name, hash] : produced) {
        found.emplace(group.empty() ? name : group + ": " + name, hash);
    }
    if (std::getenv("LAMELLA_UPDATE_GOLDEN") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
        std::erase_if(lines, [&](const auto& line) { return committed.count(line.first) == 1; });
        lines.insert(found.begin(), found.end());
        write_lines(lines);
        return;
    }
    for (const auto& [name, hash] : found) {
        INFO(name << ", committed: " << committed.count(name));
        CHECK(committed[name] == hash);
        committed.erase(name);
    }
    for (const auto& [name, hash] : committed) {
        FAIL_CHECK("committed, but no longer produced: " << name);
    }
}

Hash& add_contours(Hash& hash, std::span<const lamella::Contour> contours, std::span<const lamella::Point> points) {
    for (const lamella::Contour& contour : contours) {
        hash.add(static_cast<int>(contour.role), contour.orientation, contour.flags, contour.segments, contour.first_point,
                 contour.point_count, contour.parent, contour.twice_area.low, contour.twice_area.high);
    }
    return hash.add(points);
}

std::uint64_t hash_of(const lamella::Ledger& ledger) {
    Hash hash;
    hash.add(ledger.triangles, ledger.cut, ledger.between, ledger.degenerate, ledger.horizontal, ledger.shells.count,
             ledger.shells.triangles, ledger.peaks.count, ledger.peaks.triangles, ledger.pits.count, ledger.pits.triangles);
    hash.add(ledger.flat_up_mm2, ledger.flat_down_mm2);
    for (const lamella::LedgerSlab& slab : ledger.slabs) {
        hash.add(slab.layer, slab.triangles, slab.flat_up_mm2, slab.flat_down_mm2, slab.shells, slab.peaks, slab.pits);
    }
    for (const lamella::SurfacePiece& piece : ledger.pieces) {
        hash.add(name_of(piece.kind), piece.layer, piece.at_mm, piece.height_mm, piece.triangles);
    }
    return hash.add(ledger.gaps).value();
}

std::uint64_t hash_of(const lamella::VolumeCertificate& volume) {
    return Hash()
        .add(name_of(volume.verdict), volume.mesh_mm3, volume.slabs_mm3, volume.slab_mm3, volume.worst_layer,
             volume.worst_difference_mm2, volume.worst_allowed_mm2)
        .value();
}

std::uint64_t hash_of(const lamella::Crossings& crossings) {
    Hash hash;
    hash.add(crossings.count, crossings.at_least);
    for (const lamella::LayerCrossings& layer : crossings.layers) {
        hash.add(layer.layer, layer.count, layer.at_least, layer.first.x, layer.first.y, layer.contours);
    }
    return hash.value();
}

std::uint64_t hash_of(const lamella::MeshCheck& mesh) {
    return Hash()
        .add(mesh.triangles, mesh.degenerate, mesh.box.min_mm, mesh.box.max_mm, mesh.volume_mm3, mesh.area_mm2, mesh.edges,
             mesh.boundary_edges, mesh.overfull_edges, mesh.mismatched_edges, mesh.shell_count, mesh.grid_mm, mesh.closed)
        .value();
}

HeldMesh::HeldMesh(const Soup& soup, Form form) : form_(form) {
    const bool indexed = form == Form::f64_indexed || form == Form::f32_indexed;
    const shapes::Indexed shared = indexed ? shapes::indexed(soup) : shapes::Indexed{};
    f64_ = indexed ? shared.xyz : soup;
    f32_ = shapes::floats(f64_);
    indices_ = shared.indices;
    if (form == Form::f32_strided) {
        strided_ = shapes::records(f32_, 9, 50);
    }
}

MeshView HeldMesh::view() const {
    switch (form_) {
        case Form::f64_soup:
            return MeshView::soup(std::span<const double>(f64_));
        case Form::f32_soup:
            return MeshView::soup(std::span<const float>(f32_));
        case Form::f64_indexed:
            return MeshView::indexed(std::span<const double>(f64_), indices_);
        case Form::f32_indexed:
            return MeshView::indexed(std::span<const float>(f32_), indices_);
        default:
            return {.vertices = strided_.data() + 1, .triangle_count = f32_.size() / 9, .vertex_stride = 50};
    }
}

std::uint64_t add_slices(Hashes& hashes, const std::string& name, const MeshView& mesh, const Options& options,
                         lamella::Tuning tuning) {
    const SliceResult first = sliced(mesh, options, {.threads = 1}, tuning);
    add(hashes, name, hash_of_shapes(first));
    add(hashes, name + ", numbers", hash_of_numbers(first));
    std::uint64_t bands = first.info.bands;
    const std::vector<Way> all_ways = ways();
    // Among them eight threads in bands of the default size, swept: these work on wide planes together.
    for (std::size_t i = 2; i < all_ways.size(); i += 7) {
        INFO(name << ", " << all_ways[i]);
        tuning.instructions = all_ways[i].tuning.instructions;
        tuning.band_planes = all_ways[i].tuning.band_planes;
        tuning.form = all_ways[i].tuning.form;
        SliceResult result;  // which is as right as the first one where it has the same hash
        (void)sliced_to(result, mesh, options, all_ways[i].context, tuning);
        CHECK(hash_of_shapes(result) == hash_of_shapes(first));
        CHECK(hash_of_numbers(result) == hash_of_numbers(first));
        bands = std::max(bands, tuning.band_planes == 0 ? result.info.bands : 0);
    }
    return bands;
}

}  // namespace golden
