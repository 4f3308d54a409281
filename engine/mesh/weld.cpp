#include "lamella/weld.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "base/parallel_sort.hpp"
#include "lamella/context.hpp"
#include "lamella/grid.hpp"
#include "mesh/near_vertices.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"

namespace lamella {

namespace {

template <class Real>
struct Corner {
    Place<Real> place;
    std::uint32_t index;  // 3 * triangle + corner
};

// The progress when a step is done.
constexpr double sorted_share = 0.5;
constexpr double numbered_share = 0.65;
constexpr double searched_share = 0.85;
constexpr double joined_share = 0.9;

constexpr std::size_t weld_grain = 8192;

/// The first corner of triangle t that names a vertex that there is not, or 3.
std::size_t dangling_corner(const MeshView& mesh, std::size_t t) {
    std::size_t corner = mesh.indices != nullptr ? 0 : 3;
    while (corner < 3 && mesh.vertex_of(t, corner) < mesh.vertex_count) {
        ++corner;
    }
    return corner;
}

/// Writes the three corners of triangle t; false if a coordinate cannot be used.
template <class Real>
bool write_corners(const RawTriangle& raw, std::size_t t, Corner<Real>* corners) {
    bool usable = true;
    for (std::size_t i = 0; i < 9; ++i) {
        const auto coordinate = static_cast<Real>(raw.v[i]);
        usable = usable && std::abs(coordinate) <= static_cast<Real>(largest_coordinate_mm);
        corners[i / 3].place.at[i % 3] = coordinate + Real{0};  // one zero, not two
    }
    for (std::size_t i = 0; i < 3; ++i) {
        corners[i].index = static_cast<std::uint32_t>(3 * t + i);
    }
    return usable;
}

/// Throws Refused: why triangle t cannot be used.
[[noreturn]] void refuse_triangle(const MeshView& mesh, std::size_t t) {
    const std::string triangle = "triangle " + std::to_string(t);
    if (const std::size_t corner = dangling_corner(mesh, t); corner < 3) {
        throw Refused{{ErrorCode::invalid_argument,
                       triangle + " has index " + std::to_string(mesh.vertex_of(t, corner)) + ", but there are " +
                           std::to_string(mesh.vertex_count) + " vertices",
                       static_cast<std::int64_t>(t)}};
    }
    throw Refused{{ErrorCode::bad_coordinate, triangle + " has a coordinate that is not finite or beyond 1e9",
                   static_cast<std::int64_t>(t)}};
}

template <class Real>
Array<Corner<Real>> sorted_corners(const MeshView& mesh, const Parallel& parallel) {
    Array<Corner<Real>> corners(parallel.memory());
    corners.resize_discarding(3 * mesh.triangle_count);
    const PlacedReader read(mesh, {});
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> first_bad(static_cast<std::size_t>(parallel.threads()), none);
    parallel.run_ranges(mesh.triangle_count, weld_grain / 3, [&](std::size_t begin, std::size_t end, int worker) {
        for (std::size_t t = begin; t < end; ++t) {
            if (dangling_corner(mesh, t) < 3 || !write_corners(read(t), t, corners.data() + 3 * t)) {
                std::size_t& first = first_bad[static_cast<std::size_t>(worker)];
                first = std::min(first, t);
                return;
            }
        }
    });
    if (const std::size_t bad = *std::min_element(first_bad.begin(), first_bad.end()); bad != none) {
        refuse_triangle(mesh, bad);
    }
    // Which of two equal corners comes first does not show: both get one vertex.
    sort_in_parallel(
        corners.span(), [](const auto& a, const auto& b) { return a.place < b.place; }, parallel, parallel.memory());
    return corners;
}

/// The mesh's distinct vertices, ascending; `of_corners` gets the number of each corner's.
template <class Real>
Array<Place<Real>> distinct_places(const MeshView& mesh, std::span<std::uint32_t> of_corners, const Parallel& parallel) {
    parallel.begin_stage(sorted_share, 4);
    const Array<Corner<Real>> corners = sorted_corners<Real>(mesh, parallel);
    parallel.begin_stage(numbered_share, 2);
    Array<Place<Real>> places(parallel.memory());
    number_where(
        corners.size(), parallel, [&](std::size_t i) { return i == 0 || !(corners[i - 1].place == corners[i].place); },
        [&](std::size_t count) { places.resize_discarding(count); },
        [&](std::size_t i, std::uint32_t number, bool is_new) {
            of_corners[corners[i].index] = number;
            if (is_new) {
                places[number] = corners[i].place;
            }
        });
    return places;
}

/// The vertex that each vertex becomes.
struct Joining {
    Array<std::uint32_t> target;  ///< by vertex: the one that it moves onto, or itself
    std::uint64_t joined = 0;
    double largest_squared = 0;

    bool is_kept(std::size_t vertex) const noexcept { return target[vertex] == vertex; }
};

/// The vertices that have another before them within the tolerance are found on all threads; where they are many, most of
/// the time. They then decide one after the other, since what each finds depends on where those before it have moved.
template <class Real>
Joining join(std::span<const Place<Real>> places, double tolerance, const Parallel& parallel) {
    constexpr std::size_t vertices_between_stops = std::size_t{1} << 12;
    parallel.begin_stage(searched_share, 5);
    NearVertices<Real> near(places, tolerance, parallel);
    Joining joining{Array<std::uint32_t>(parallel.memory())};
    joining.target.resize_discarding(places.size());
    parallel.run_ranges(places.size(), weld_grain, [&](std::size_t begin, std::size_t end, int) {
        std::iota(joining.target.begin() + begin, joining.target.begin() + end, static_cast<std::uint32_t>(begin));
    });
    const Array<std::uint32_t> waiting = indices_where(places.size(), parallel, parallel.memory(), [&](std::size_t v) {
        return near.has_earlier(static_cast<std::uint32_t>(v));
    });
    for (std::size_t i = 0; i < waiting.size(); ++i) {
        if (i % vertices_between_stops == 0) {
            parallel.stop_if_asked();
            parallel.reach(searched_share +
                           (joined_share - searched_share) * static_cast<double>(i) / static_cast<double>(waiting.size()));
        }
        const std::uint32_t vertex = waiting[i];
        const std::uint32_t nearest = near.nearest_kept(vertex);
        if (nearest != NearVertices<Real>::none) {
            joining.target[vertex] = nearest;
            near.drop(vertex);
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
    welded.indices.resize_discarding(3 * mesh.triangle_count);
    const Array<Place<Real>> places = distinct_places<Real>(mesh, welded.indices.span(), parallel);
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
