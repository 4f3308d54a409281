// Exact tests of points against edges and contours.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella::nesting {

static_assert(grid_limit <= 1 << 30,
              "products of two coordinate differences must fit 63 bits, so that they compare exactly");

/// Sign of the turn a -> b -> q: +1 where q lies left of a -> b, 0 on its line, -1 right. The products are compared, never
/// subtracted: their difference could overflow.
inline int side_of(Point a, Point b, Point q) noexcept {
    const std::int64_t left = (std::int64_t{b.x} - a.x) * (std::int64_t{q.y} - a.y);
    const std::int64_t right = (std::int64_t{b.y} - a.y) * (std::int64_t{q.x} - a.x);
    return (left > right) - (left < right);
}

/// Winding number of a contour around a point, by the ray from the point towards +x: an edge that crosses it upwards counts
/// one, downwards minus one. Only edges that straddle the point's y, or begin at it, need be shown.
class Winding {
public:
    explicit Winding(Point query) noexcept : query_(query) {}

    void add(Point a, Point b) noexcept {
        const bool a_above = a.y > query_.y;
        const bool b_above = b.y > query_.y;
        if (a_above != b_above) {
            const int side = side_of(a, b, query_);
            on_boundary_ |= side == 0;
            number_ += (b_above && side > 0) - (a_above && side < 0);
        } else if (a.y == query_.y) {
            const auto [low, high] = std::minmax(a.x, b.x);
            on_boundary_ |= a.x == query_.x || (b.y == query_.y && low <= query_.x && query_.x <= high);
        }
    }
    Point query() const noexcept { return query_; }
    /// The boundary does not count as inside.
    bool strictly_inside() const noexcept { return number_ != 0 && !on_boundary_; }

private:
    Point query_;
    int number_ = 0;
    bool on_boundary_ = false;
};

/// Shows `winding` those of the `count` edges between points[0] and points[count] that it needs to see.
using AddEdges = void (*)(Winding& winding, const Point* points, std::uint32_t count) noexcept;

void add_edges_portable(Winding& winding, const Point* points, std::uint32_t count) noexcept;

/// The fastest form that this processor runs. All give the same answers.
AddEdges best_add_edges() noexcept;

/// Whether the non-zero winding interior of a closed contour contains `query`. O(count).
inline bool strictly_inside(AddEdges add_edges, const Point* points, std::uint32_t count, Point query) noexcept {
    Winding winding(query);
    add_edges(winding, points, count - 1);
    winding.add(points[count - 1], points[0]);
    return winding.strictly_inside();
}

/// The y extents of runs of a contour's edges, and of runs of runs, for contours that many points are tested against:
///
///     level 1   [.................|.................|... ]   16 runs each
///     level 0   [||||||||||||||||]|                          32 edges each
///
/// A test descends where the extent holds the point's y: O(edges at that y x log count).
class EdgeIndex {
public:
    explicit EdgeIndex(std::pmr::memory_resource* memory) : extents_(memory) {}

    void clear() noexcept { extents_.clear(); }
    /// Returns the handle of the contour for strictly_inside(). Throws std::bad_alloc.
    std::size_t add(const Point* points, std::uint32_t count);
    bool strictly_inside(std::size_t handle, AddEdges add_edges, const Point* points, std::uint32_t count,
                         Point query) const noexcept;

    static constexpr std::uint32_t run_edges = 32;
    static constexpr std::uint32_t runs_per_run = 16;

private:
    struct Extent {
        std::int32_t low, high;
    };
    std::pmr::vector<Extent> extents_;
};

}  // namespace lamella::nesting
