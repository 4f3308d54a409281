// Exact tests of points against edges and contours.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella::nesting {

/// Winding number of a contour around a point, by the ray from the point towards +x: an edge that crosses it upwards counts
/// one, downwards minus one. Only edges that straddle the point's y, or begin at it, need be added.
class Winding {
public:
    Winding() = default;
    explicit Winding(Point query) noexcept : query_(query) {}

    void add(Point a, Point b) noexcept {
        const bool a_above = a.y > query_.y;
        const bool b_above = b.y > query_.y;
        const bool straddles = a_above != b_above;
        const int side = side_of(a, b, query_);
        on_boundary_ |= straddles & (side == 0);
        number_ += (straddles & b_above & (side > 0)) - (straddles & a_above & (side < 0));
        if (a.y == query_.y) {
            const auto [left, right] = std::minmax(a.x, b.x);
            on_boundary_ |= a.x == query_.x || (b.y == query_.y && left <= query_.x && query_.x <= right);
        }
    }
    Point query() const noexcept { return query_; }
    /// The boundary does not count as inside.
    bool strictly_inside() const noexcept { return number_ != 0 && !on_boundary_; }
    bool on_boundary() const noexcept { return on_boundary_; }

private:
    Point query_;
    int number_ = 0;
    bool on_boundary_ = false;
};

/// Adds to `winding` those of the `count` edges between points[0] and points[count] that it needs.
using AddEdges = void (*)(Winding& winding, const Point* points, std::uint32_t count) noexcept;

/// All forms, the fastest first.
std::span<const Form<AddEdges>> add_edges_forms() noexcept;

/// Of a closed contour around `query`. O(count).
inline Winding winding_around(AddEdges add_edges, const Point* points, std::uint32_t count, Point query) noexcept {
    Winding winding(query);
    add_edges(winding, points, count - 1);
    winding.add(points[count - 1], points[0]);
    return winding;
}

/// True if the non-zero winding interior of a closed contour contains `query`. O(count).
inline bool strictly_inside(AddEdges add_edges, const Point* points, std::uint32_t count, Point query) noexcept {
    return winding_around(add_edges, points, count, query).strictly_inside();
}

/// The range of y that points lie in, in equal steps. What lies below all of them is in the first step, what lies above in
/// the last: neither has a point.
struct LevelSteps {
    std::int32_t low = 0;  // less than the lowest by one
    std::int32_t high = 0;
    int shift = 0;  // a step has 2^shift values
    const std::uint32_t* firsts =
        nullptr;  // of each step, and of what follows the last: its first point in the order of steps

    std::uint32_t of(std::int32_t y) const noexcept {
        const std::uint32_t above_low =
            static_cast<std::uint32_t>(std::clamp(y, low, high)) - static_cast<std::uint32_t>(low);
        return (above_low + (1U << shift) - 1) >> shift;
    }
};

/// Edges from points[edge[i]] to the next that reach the steps of points first[i] to last[i].
struct ReachingEdges {
    static constexpr std::uint32_t most = 64;
    static constexpr std::uint32_t room = most + 16;  // a form may write beyond what it finds
    std::array<std::uint32_t, room> edge, first, last;
};

/// Those of the `count` <= ReachingEdges::most edges from points[0] to points[count] that reach a step with a point; how
/// many.
using SiftEdges = std::size_t (*)(const LevelSteps& steps, const Point* points, std::uint32_t count,
                                  ReachingEdges& reaching) noexcept;

/// All forms, the fastest first.
std::span<const Form<SiftEdges>> sift_edges_forms() noexcept;

/// Tests many points against one contour in a single pass over its edges, most of which reach no point's y. The range of y
/// is cut into some equal steps for each point, and an edge is added to the points in the steps that it reaches:
///
///     steps of y       | 0 1 |     |  2  |     | 3 4 |
///     a and b                   '     '                   the edge from `a` to `b` is added to 2
///     c                         '                         the edge from `b` to `c` is added to 2, too
///
/// O(points + edges + pairs of a point and an edge that share a step).
class ManyInside {
public:
    explicit ManyInside(Worker& worker) noexcept : worker_(worker) {}

    void clear() noexcept { queries_.clear(); }
    /// Throws std::bad_alloc.
    void add(Point point, std::uint32_t number) { queries_.push_back({Winding(point), number}); }
    /// Appends the numbers of the points added that lie strictly inside to `inside`, in an unspecified order, and of those
    /// on the contour to `touching` where it is given. Throws std::bad_alloc.
    void test(const Point* points, std::uint32_t count, Vector<std::uint32_t>& inside,
              Vector<std::uint32_t>* touching = nullptr);

private:
    struct Query {
        Winding winding;
        std::uint32_t number = 0;
        std::int32_t y() const noexcept { return winding.query().y; }
    };
    /// From queries_ to by_step_ and firsts_.
    LevelSteps sort_by_step();
    void add_edge(Point from, Point to, std::uint32_t first, std::uint32_t last);

    Worker& worker_;
    SiftEdges sift_edges_ = best_of(sift_edges_forms(), worker_.instructions());
    Vector<Query> queries_{worker_.memory()};
    Vector<Query> by_step_{worker_.memory()};         // queries_
    Vector<std::uint32_t> firsts_{worker_.memory()};  // of each step: its first of by_step_
};

}  // namespace lamella::nesting
