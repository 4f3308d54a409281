#include "lamella/weld.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "lamella/context.hpp"
#include "mesh/near_vertices.hpp"
#include "mesh/vertex_numbers.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"

namespace lamella {

namespace {

/// Reads vertices as the mesh has them.
template <class Real>
class PlaceCorners {
public:
    using Vertex = Place<Real>;
    explicit PlaceCorners(const MeshView& mesh) noexcept : read_(mesh, {}) {}

    std::array<Vertex, 3> operator()(std::size_t t) const noexcept {
        const RawTriangle raw = read_(t);
        std::array<Vertex, 3> corners;
        for (std::size_t i = 0; i < 9; ++i) {
            corners[i / 3].at[i % 3] = static_cast<Real>(raw.v[i]) + Real{0};  // one zero, not two
        }
        return corners;
    }
    static std::uint64_t hash(const Vertex& vertex) noexcept {
        const auto bits = [&](std::size_t i) { return std::bit_cast<std::uint64_t>(static_cast<double>(vertex.at[i])); };
        return mix64(mix64(mix64(bits(0)) ^ bits(1)) ^ bits(2));
    }
    static Real key(const Vertex& vertex) noexcept { return vertex.at[0]; }
    static bool differ(const Vertex& /*a*/, const Vertex& /*b*/) noexcept { return false; }

private:
    PlacedReader read_;
};

// The progress when a step is done.
constexpr double measured_share = 0.05;
constexpr double numbered_share = 0.65;
constexpr double joined_share = 0.9;

constexpr std::size_t weld_grain = 8192;

/// The vertex that each vertex becomes.
struct Joining {
    Array<std::uint32_t> target;  ///< by vertex: the one that it moves onto, or itself
    std::uint64_t joined = 0;
    double largest_squared = 0;

    bool is_kept(std::size_t vertex) const noexcept { return target[vertex] == vertex; }
};

/// Vertices decide one after the other, since what each finds depends on which of those before it are kept.
template <class Real>
Joining join(std::span<const Place<Real>> places, double tolerance, const Parallel& parallel) {
    constexpr std::uint32_t vertices_between_stops = 1 << 12;
    NearVertices<Real> near(places, tolerance, parallel);
    Joining joining{Array<std::uint32_t>(parallel.memory())};
    joining.target.resize_discarding(places.size());
    for (std::uint32_t vertex = 0; vertex < places.size(); ++vertex) {
        if (vertex % vertices_between_stops == 0) {
            parallel.stop_if_asked();
            parallel.reach(numbered_share + (joined_share - numbered_share) * vertex / static_cast<double>(places.size()));
        }
        const std::uint32_t nearest = near.nearest(vertex);
        if (nearest == NearVertices<Real>::none) {
            joining.target[vertex] = vertex;
            near.keep(vertex);
        } else {
            joining.target[vertex] = nearest;
            ++joining.joined;
            joining.largest_squared = std::max(joining.largest_squared, near.squared_distance(vertex, nearest));
        }
    }
    return joining;
}

/// Writes the coordinates of the vertices that are kept, and their numbers in place of those among all.
template <class Real>
void keep(std::span<const Place<Real>> places, const Joining& joining, const Parallel& parallel, WeldedMesh& welded) {
    Array<std::uint32_t> number_of(parallel.memory());
    number_of.resize_discarding(places.size());
    number_where(
        places.size(), parallel, [&](std::size_t v) { return joining.is_kept(v); },
        [&](std::size_t count) {
            welded.vertex_count = count;
            welded.coordinates.resize_discarding(count * sizeof(Place<Real>));
        },
        [&](std::size_t v, std::uint32_t number, bool kept) {
            if (kept) {
                number_of[v] = number;
                std::memcpy(welded.coordinates.data() + number * sizeof places[v], &places[v], sizeof places[v]);
            }
        });
    parallel.run_ranges(welded.indices.size(), weld_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            welded.indices[i] = number_of[joining.target[welded.indices[i]]];
        }
    });
}

template <class Real>
void keep_all(std::span<const Place<Real>> places, const Parallel& parallel, WeldedMesh& welded) {
    welded.vertex_count = places.size();
    welded.coordinates.resize_discarding(places.size_bytes());
    parallel.run_ranges(places.size(), weld_grain, [&](std::size_t begin, std::size_t end, int) {
        std::memcpy(welded.coordinates.data() + begin * sizeof places[0], places.data() + begin,
                    (end - begin) * sizeof places[0]);
    });
}

template <class Real>
WeldedMesh weld_corners(const MeshView& mesh, double tolerance, const Parallel& parallel) {
    WeldedMesh welded{Array<std::byte>(parallel.memory()), Array<std::uint32_t>(parallel.memory()),
                      std::is_same_v<Real, float> ? Number::f32 : Number::f64};
    parallel.begin_stage(numbered_share, 9);
    const PlaceCorners<Real> corners(mesh);
    VertexNumbers numbers(corners, mesh.triangle_count, parallel);
    const Array<Place<Real>>& places = numbers.vertices;
    welded.indices = std::move(numbers.of_corners);
    Joining joining;
    if (tolerance > 0) {  // else equal vertices are one already
        joining = join(places.span(), tolerance, parallel);
    }
    parallel.begin_stage(1, 3);
    if (joining.joined == 0) {
        keep_all(places.span(), parallel, welded);
    } else {
        keep(places.span(), joining, parallel, welded);
    }
    welded.joined = joining.joined;
    welded.largest_move_mm = std::sqrt(joining.largest_squared);
    return welded;
}

Result<WeldedMesh> weld_or_throw(const MeshView& mesh, double tolerance_mm, const Context& context) {
    constexpr double smallest = 1e-9;  // so that the cells of all coordinates have 64-bit numbers
    if (const Status status = check_mesh(mesh); !status) {
        return status.error();
    }
    const double tolerance = tolerance_mm / mesh.mm_per_unit;
    if (!(tolerance == 0 || tolerance >= smallest) || !std::isfinite(tolerance)) {
        return Error{ErrorCode::invalid_argument, "the welding tolerance must be 0 or between 1e-9 and what is finite"};
    }
    if (mesh.triangle_count == 0) {
        return Error{ErrorCode::empty_mesh, "holds no triangles"};
    }
    if (mesh.triangle_count > std::numeric_limits<std::uint32_t>::max() / 3) {
        return Error{ErrorCode::invalid_argument, "more than 2^32 / 3 triangles cannot be welded"};
    }
    const Parallel parallel(context);
    parallel.begin_stage(measured_share);
    BlockTable blocks(parallel.memory());
    require(measure_bounds(mesh, {}, 0, parallel, blocks));  // every index and coordinate can be used
    WeldedMesh welded = mesh.vertex_type == Number::f32 ? weld_corners<float>(mesh, tolerance, parallel)
                                                        : weld_corners<double>(mesh, tolerance, parallel);
    parallel.finish();
    welded.tolerance_mm = tolerance_mm;
    welded.mm_per_unit = mesh.mm_per_unit;
    welded.largest_move_mm *= mesh.mm_per_unit;
    return welded;
}

}  // namespace

Result<WeldedMesh> weld(const MeshView& mesh, double tolerance_mm, const Context& context) noexcept {
    return guarded(context, [&] { return weld_or_throw(mesh, tolerance_mm, context); });
}

}  // namespace lamella
