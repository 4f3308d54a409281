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
#include "mesh/check/finders.hpp"
#include "mesh/vertex_numbers.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

/// A vertex as the mesh has it.
using Place = std::array<double, 3>;

/// Reads vertices as the mesh has them.
class PlaceCorners {
public:
    using Vertex = Place;
    explicit PlaceCorners(const MeshView& mesh) noexcept : read_(mesh, {}) {}

    std::array<Vertex, 3> operator()(std::size_t t) const noexcept {
        const RawTriangle raw = read_(t);
        std::array<Vertex, 3> corners;
        for (std::size_t i = 0; i < 9; ++i) {
            corners[i / 3][i % 3] = raw.v[i] + 0.0;  // one zero, not two
        }
        return corners;
    }
    static std::uint64_t hash(const Vertex& vertex) noexcept {
        const auto bits = [&](std::size_t i) { return bits_as<std::uint64_t>(vertex[i]); };
        return mix64(mix64(mix64(bits(0)) ^ bits(1)) ^ bits(2));
    }
    static double key(const Vertex& vertex) noexcept { return vertex[0]; }
    static bool differ(const Vertex& /*a*/, const Vertex& /*b*/) noexcept { return false; }

private:
    PlacedReader read_;
};

/// The vertices that are kept, found again by where they lie: in chains, one for each cell of a grid so coarse that a search
/// seldom has to look into two.
class NearVertices {
public:
    using Vertex = std::uint32_t;
    static constexpr Vertex none = std::numeric_limits<Vertex>::max();

    /// No vertex is kept yet. `places` ascend and outlive this. Throws std::bad_alloc.
    NearVertices(std::span<const Place> places, double tolerance, const Parallel& parallel)
        : places_(places), tolerance_(tolerance), newest_(parallel.memory()), before_(parallel.memory()) {
        newest_.resize_discarding(std::bit_ceil(places.size() / 2 + 1));
        parallel.run_ranges(newest_.size(), std::size_t{1} << 16, [this](std::size_t begin, std::size_t end, int) {
            std::fill(newest_.begin() + begin, newest_.begin() + end, none);
        });
        before_.resize_discarding(places.size());
    }

    /// To be called in ascending order.
    void keep(Vertex vertex) { before_[vertex] = std::exchange(newest_[chain_of(cell_of(vertex))], vertex); }

    /// The nearest of the vertices that are kept and within the tolerance, the first of those as near; or none. Of a chain,
    /// which descends, all lie beyond reach from the first on that does in x.
    Vertex nearest(Vertex vertex) const {
        Vertex nearest = none;
        double nearest_squared = tolerance_ * tolerance_;
        for_each_chain_near(vertex, [&](Vertex other) {
            for (; other != none && coordinate(vertex, 0) - coordinate(other, 0) <= tolerance_; other = before_[other]) {
                const double squared = squared_distance(vertex, other);
                if (squared < nearest_squared || (squared == nearest_squared && other < nearest)) {
                    nearest = other;
                    nearest_squared = squared;
                }
            }
        });
        return nearest;
    }

    double squared_distance(Vertex a, Vertex b) const noexcept {
        double sum = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double difference = coordinate(a, axis) - coordinate(b, axis);
            sum += difference * difference;
        }
        return sum;
    }

private:
    using CellNumbers = std::array<std::int64_t, 3>;
    static constexpr double cells_per_tolerance = 1.0 / 16;

    double coordinate(Vertex vertex, std::size_t axis) const noexcept { return places_[vertex][axis]; }

    /// Of the place that lies `beside` the vertex on all axes.
    CellNumbers cell_of(Vertex vertex, double beside = 0) const noexcept {
        const auto number = [&](std::size_t axis) {
            return static_cast<std::int64_t>(
                std::floor((coordinate(vertex, axis) + beside) / tolerance_ * cells_per_tolerance));
        };
        return {number(0), number(1), number(2)};
    }

    /// Cells that share a chain are searched together, which does no harm.
    std::size_t chain_of(const CellNumbers& cell) const noexcept {
        std::uint64_t hash = 0;
        for (const std::int64_t number : cell) {
            hash = mix64(hash ^ static_cast<std::uint64_t>(number));
        }
        return static_cast<std::size_t>(hash) & (newest_.size() - 1);
    }

    /// Calls see(newest vertex of the chain) for each cell that the tolerance around the vertex reaches.
    template <class See>
    void for_each_chain_near(Vertex vertex, const See& see) const {
        const CellNumbers low = cell_of(vertex, -tolerance_);
        const CellNumbers high = cell_of(vertex, tolerance_);
        for (std::int64_t x = low[0]; x <= high[0]; ++x) {
            for (std::int64_t y = low[1]; y <= high[1]; ++y) {
                for (std::int64_t z = low[2]; z <= high[2]; ++z) {
                    see(newest_[chain_of({x, y, z})]);
                }
            }
        }
    }

    std::span<const Place> places_;
    double tolerance_;
    Array<Vertex> newest_;  ///< by chain; none where it is empty
    Array<Vertex> before_;  ///< by kept vertex: the one before it in its chain
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

    bool is_kept(std::size_t vertex) const noexcept { return joined == 0 || target[vertex] == vertex; }
};

/// Vertices decide one after the other, since what each finds depends on which of those before it are kept.
Joining join(std::span<const Place> places, double tolerance, const Parallel& parallel) {
    constexpr std::uint32_t vertices_between_stops = 1 << 12;
    NearVertices near(places, tolerance, parallel);
    Joining joining{Array<std::uint32_t>(parallel.memory())};
    joining.target.resize_discarding(places.size());
    for (std::uint32_t vertex = 0; vertex < places.size(); ++vertex) {
        if (vertex % vertices_between_stops == 0) {
            parallel.stop_if_asked();
            parallel.reach(numbered_share + (joined_share - numbered_share) * vertex / static_cast<double>(places.size()));
        }
        const std::uint32_t nearest = near.nearest(vertex);
        if (nearest == NearVertices::none) {
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

/// As numbers of the type.
template <class Real>
void write_place(const Place& place, std::byte* to) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto number = static_cast<Real>(place[axis]);
        std::memcpy(to + axis * sizeof number, &number, sizeof number);
    }
}

/// Writes the coordinates of the vertices that are kept, and their numbers in place of those among all.
void keep(std::span<const Place> places, const Joining& joining, const Parallel& parallel, WeldedMesh& welded) {
    const bool floats = welded.vertex_type == Number::f32;
    const std::size_t bytes = 3 * (floats ? sizeof(float) : sizeof(double));
    Array<std::uint32_t> number_of(parallel.memory());
    number_of.resize_discarding(places.size());
    number_where(
        places.size(), parallel, [&](std::size_t v) { return joining.is_kept(v); },
        [&](std::size_t count) {
            welded.vertex_count = count;
            welded.coordinates.resize_discarding(count * bytes);
        },
        [&](std::size_t v, std::uint32_t number, bool kept) {
            if (kept) {
                number_of[v] = number;
                std::byte* const to = welded.coordinates.data() + number * bytes;
                floats ? write_place<float>(places[v], to) : write_place<double>(places[v], to);
            }
        });
    if (joining.joined == 0) {
        return;
    }
    parallel.run_ranges(welded.indices.size(), weld_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            welded.indices[i] = number_of[joining.target[welded.indices[i]]];
        }
    });
}

WeldedMesh weld_within(const MeshView& mesh, double tolerance, const Parallel& parallel) {
    WeldedMesh welded{Array<std::byte>(parallel.memory()), Array<std::uint32_t>(parallel.memory()),
                      mesh.vertex_type == Number::f32 ? Number::f32 : Number::f64};
    parallel.begin_stage(numbered_share, 9);
    const PlaceCorners corners(mesh);
    VertexNumbers numbers(corners, mesh.triangle_count, parallel);
    const Array<Place>& places = numbers.vertices;
    welded.indices = std::move(numbers.of_corners);
    Joining joining;
    if (tolerance > 0) {  // else equal vertices are one already
        joining = join(places.span(), tolerance, parallel);
    }
    parallel.begin_stage(1, 3);
    keep(places.span(), joining, parallel, welded);
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
    WeldedMesh welded = weld_within(mesh, tolerance, parallel);
    parallel.finish();
    welded.tolerance_mm = tolerance_mm;
    welded.mm_per_unit = mesh.mm_per_unit;
    welded.largest_move_mm *= mesh.mm_per_unit;
    return welded;
}

}  // namespace

WeldedMesh weld_equal(const MeshView& mesh, const Parallel& parallel) {
    return weld_within(mesh, 0, parallel);
}

Result<WeldedMesh> weld(const MeshView& mesh, double tolerance_mm, const Context& context) noexcept {
    return guarded(context, [&] { return weld_or_throw(mesh, tolerance_mm, context); });
}

}  // namespace lamella
