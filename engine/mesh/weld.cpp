#include "lamella/mesh/weld.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/parallel_sort.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "lamella/memory.hpp"

namespace lamella {

namespace {

template <class Number>
struct Corner {
    Number at[3];
    std::uint32_t index;  // 3 * triangle + corner

    auto coordinates() const noexcept { return std::tie(at[0], at[1], at[2]); }
};

struct Cell {
    std::int64_t of[3];
    friend bool operator==(const Cell&, const Cell&) = default;
};

struct CellHash {
    std::size_t operator()(const Cell& cell) const noexcept {
        std::uint64_t h = 0;
        for (const std::int64_t of : cell.of) {
            h = (h ^ static_cast<std::uint64_t>(of)) * 0x9E3779B97F4A7C15U;
            h ^= h >> 32;
        }
        return h;
    }
};

constexpr double sorted_share = 0.5;  ///< of the progress, when corners are sorted

/// The vertices kept so far, by cell of a grid so coarse that a vertex seldom has to look into two.
class KeptVertices {
public:
    static constexpr double cells_per_tolerance = 1.0 / 16;
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

    KeptVertices(double tolerance, const Memory* memory)
        : tolerance_(tolerance), head_(HeadAllocator(memory)), next_(memory), coordinates_(memory) {}

    /// The nearest kept vertex within the tolerance, the first kept of those as near; or `none`.
    std::uint32_t nearest(const double* at) {
        nearest_ = none;
        if (tolerance_ == 0) {
            return none;  // equal vertices are found without a search
        }
        nearest_squared_ = tolerance_ * tolerance_;
        Cell low;
        Cell high;
        for (int axis = 0; axis < 3; ++axis) {
            low.of[axis] = cell_of(at[axis] - tolerance_);
            high.of[axis] = cell_of(at[axis] + tolerance_);
        }
        for (std::int64_t x = low.of[0]; x <= high.of[0]; ++x) {
            for (std::int64_t y = low.of[1]; y <= high.of[1]; ++y) {
                for (std::int64_t z = low.of[2]; z <= high.of[2]; ++z) {
                    search({{x, y, z}}, at);
                }
            }
        }
        return nearest_;
    }

    /// `at` in ascending order of x.
    void keep(const double* at) {
        const auto vertex = static_cast<std::uint32_t>(next_.size());
        const auto [place, is_new] = head_.try_emplace(Cell{{cell_of(at[0]), cell_of(at[1]), cell_of(at[2])}}, vertex);
        next_.push_back(is_new ? none : std::exchange(place->second, vertex));
        coordinates_.insert(coordinates_.end(), at, at + 3);
    }

    double squared_distance(std::uint32_t vertex, const double* at) const noexcept {
        const double* kept = coordinates_.data() + 3 * std::size_t{vertex};
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double difference = at[axis] - kept[axis];
            sum += difference * difference;
        }
        return sum;
    }
    std::size_t size() const noexcept { return next_.size(); }
    const Vector<double>& coordinates() const noexcept { return coordinates_; }

private:
    /// With a tolerance of zero any cell does.
    std::int64_t cell_of(double at) const noexcept {
        return static_cast<std::int64_t>(std::floor(tolerance_ > 0 ? at / tolerance_ * cells_per_tolerance : at));
    }

    /// From the last vertex of the cell on, which has the largest x, down to where x is out of reach.
    void search(const Cell& cell, const double* at) {
        const auto found = head_.find(cell);
        for (std::uint32_t v = found == head_.end() ? none : found->second;
             v != none && at[0] - coordinates_[3 * std::size_t{v}] <= tolerance_; v = next_[v]) {
            const double squared = squared_distance(v, at);
            if (squared < nearest_squared_ || (squared == nearest_squared_ && v < nearest_)) {
                nearest_ = v;
                nearest_squared_ = squared;
            }
        }
    }

    using HeadAllocator = Allocator<std::pair<const Cell, std::uint32_t>>;

    double tolerance_;
    std::unordered_map<Cell, std::uint32_t, CellHash, std::equal_to<>, HeadAllocator> head_;  // the last kept in each cell
    Vector<std::uint32_t> next_;                                                              // the one kept before it there
    Vector<double> coordinates_;
    std::uint32_t nearest_ = none;
    double nearest_squared_ = 0;
};

constexpr std::size_t weld_grain = 8192;

/// Reads a corner; false if a coordinate cannot be used.
template <class Number>
bool read_corner(const MeshView& mesh, std::size_t i, Corner<Number>& corner) {
    const std::byte* at = mesh.indices != nullptr ? mesh.vertices + mesh.indices[i] * mesh.stride
                                                  : mesh.vertices + i / 3 * mesh.stride + i % 3 * 3 * sizeof(Number);
    std::memcpy(corner.at, at, sizeof corner.at);
    corner.index = static_cast<std::uint32_t>(i);
    bool usable = true;
    for (Number& coordinate : corner.at) {
        usable = usable && std::abs(coordinate) <= static_cast<Number>(largest_coordinate_mm);
        coordinate += Number{0};  // one zero, not two
    }
    return usable;
}

/// Of corner `i`, the first that cannot be used.
Error unusable(const MeshView& mesh, std::size_t i) {
    const std::string triangle = "triangle " + std::to_string(i / 3);
    if (mesh.indices != nullptr && mesh.indices[i] >= mesh.vertex_count) {
        return {ErrorCode::invalid_argument,
                triangle + " has index " + std::to_string(mesh.indices[i]) + ", but there are " +
                    std::to_string(mesh.vertex_count) + " vertices",
                static_cast<std::int64_t>(i / 3)};
    }
    return {ErrorCode::bad_coordinate, triangle + " has a coordinate that is not finite or beyond 1e9",
            static_cast<std::int64_t>(i / 3)};
}

template <class Number>
Result<Vector<Corner<Number>>> sorted_corners(const MeshView& mesh, const Memory* memory, const Parallel& parallel) {
    Vector<Corner<Number>> corners(3 * mesh.triangle_count, memory);
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> first_bad(static_cast<std::size_t>(parallel.threads()), none);
    parallel.run_ranges(corners.size(), weld_grain, [&](std::size_t begin, std::size_t end, int worker) {
        for (std::size_t i = begin; i < end; ++i) {
            const bool no_vertex = mesh.indices != nullptr && mesh.indices[i] >= mesh.vertex_count;
            if (no_vertex || !read_corner(mesh, i, corners[i])) {
                std::size_t& first = first_bad[static_cast<std::size_t>(worker)];
                first = std::min(first, i);
                return;
            }
        }
    });
    if (const std::size_t bad = *std::min_element(first_bad.begin(), first_bad.end()); bad != none) {
        return unusable(mesh, bad);
    }
    // Which of two equal corners comes first does not show: both get one vertex.
    sort_in_parallel(
        std::span<Corner<Number>>(corners.data(), corners.size()),
        [](const auto& a, const auto& b) { return a.coordinates() < b.coordinates(); }, parallel, memory);
    return corners;
}

template <class Number>
Result<WeldedMesh> weld_corners(const MeshView& mesh, double tolerance, const Memory* memory, const Parallel& parallel) {
    parallel.begin_stage(sorted_share, 4);
    const Result<Vector<Corner<Number>>> corners = sorted_corners<Number>(mesh, memory, parallel);
    if (!corners) {
        return corners.error();
    }
    WeldedMesh welded{Array<std::byte>(memory), Array<std::uint32_t>(memory), mesh.coordinate_type};
    welded.indices.resize_discarding(corners.value().size());
    KeptVertices kept(tolerance, memory);
    const Corner<Number>* last = nullptr;
    std::uint32_t vertex = 0;
    constexpr std::size_t corners_between_stops = std::size_t{1} << 14;
    std::size_t seen = 0;
    for (const Corner<Number>& corner : corners.value()) {
        if (seen++ % corners_between_stops == 0) {
            parallel.stop_if_asked();
            parallel.reach(sorted_share +
                           (1 - sorted_share) * static_cast<double>(seen) / static_cast<double>(corners.value().size() + 1));
        }
        if (last == nullptr || last->coordinates() != corner.coordinates()) {
            const double at[3] = {static_cast<double>(corner.at[0]), static_cast<double>(corner.at[1]),
                                  static_cast<double>(corner.at[2])};
            vertex = kept.nearest(at);
            if (vertex == KeptVertices::none) {
                vertex = static_cast<std::uint32_t>(kept.size());
                kept.keep(at);
            } else {
                ++welded.joined;
                welded.largest_move_mm = std::max(welded.largest_move_mm, std::sqrt(kept.squared_distance(vertex, at)));
            }
        }
        welded.indices[corner.index] = vertex;
        last = &corner;
    }
    welded.vertex_count = kept.size();
    welded.coordinates.resize_discarding(kept.coordinates().size() * sizeof(Number));
    for (std::size_t i = 0; i < kept.coordinates().size(); ++i) {
        const auto coordinate = static_cast<Number>(kept.coordinates()[i]);  // which it was before
        std::memcpy(welded.coordinates.data() + i * sizeof(Number), &coordinate, sizeof coordinate);
    }
    return welded;
}

Result<WeldedMesh> weld_or_throw(const MeshView& mesh, const WeldOptions& options) {
    constexpr double smallest = 1e-9;  // so that the cells of all coordinates have 64-bit numbers
    if (!(options.mm_per_unit > 0) || !std::isfinite(options.mm_per_unit)) {
        return Error{ErrorCode::invalid_argument, "the mesh's unit must be a positive number of mm"};
    }
    const double tolerance = options.tolerance_mm / options.mm_per_unit;
    if (!(tolerance == 0 || tolerance >= smallest) || !std::isfinite(tolerance)) {
        return Error{ErrorCode::invalid_argument, "the welding tolerance must be 0 or between 1e-9 and what is finite"};
    }
    if (mesh.triangle_count == 0) {
        return Error{ErrorCode::empty_mesh, "holds no triangles"};
    }
    if (mesh.triangle_count > std::numeric_limits<std::uint32_t>::max() / 3) {
        return Error{ErrorCode::invalid_argument, "more than 2^32 / 3 triangles cannot be welded"};
    }
    const Parallel parallel(options.control);
    const Memory* const memory = options.control.memory;
    Result<WeldedMesh> welded = mesh.coordinate_type == CoordinateType::f32
                                    ? weld_corners<float>(mesh, tolerance, memory, parallel)
                                    : weld_corners<double>(mesh, tolerance, memory, parallel);
    if (welded) {
        parallel.finish();
        welded->tolerance_mm = options.tolerance_mm;
        welded->mm_per_unit = options.mm_per_unit;
        welded->largest_move_mm *= options.mm_per_unit;
    }
    return welded;
}

}  // namespace

Result<WeldedMesh> weld(const MeshView& mesh, const WeldOptions& options) noexcept {
    return guarded(options.control, [&] { return weld_or_throw(mesh, options); });
}

Result<SliceResult> slice(const WeldedMesh& mesh, const SliceOptions& options) noexcept {
    return guarded([&] {
        SliceOptions in_mm = options;
        in_mm.transform = options.transform * mesh.to_mm();
        return slice(mesh.view(), in_mm);
    });
}

}  // namespace lamella
