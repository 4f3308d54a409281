// Exact tests of points against edges and contours.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/query_steps.hpp"

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

private:
    Point query_;
    int number_ = 0;
    bool on_boundary_ = false;
};

/// Adds to `winding` those of the `count` edges between points[0] and points[count] that it needs.
using AddEdges = void (*)(Winding& winding, const Point* points, std::uint32_t count) noexcept;

/// All forms, the fastest first.
std::span<const Form<AddEdges>> add_edges_forms() noexcept;

/// Whether the non-zero winding interior of a closed contour contains `query`. O(count).
inline bool strictly_inside(AddEdges add_edges, const Point* points, std::uint32_t count, Point query) noexcept {
    Winding winding(query);
    add_edges(winding, points, count - 1);
    winding.add(points[count - 1], points[0]);
    return winding.strictly_inside();
}

/// Tests many points against one contour in a single pass over its edges, most of which reach no point's y.
/// O(points log points + edges log points + pairs of a point and an edge that share a y).
class ManyInside {
public:
    explicit ManyInside(const Memory* memory)
        : sift_edges_(best_of(sift_edges_forms())), queries_(memory), by_y_(memory), ends_(memory) {}

    void clear() noexcept { queries_.clear(); }
    /// Throws std::bad_alloc.
    void add(Point point, std::uint32_t number) { queries_.push_back({Winding(point), number}); }
    /// Appends the numbers of the points added that lie strictly inside to `inside`, in an unspecified but reproducible
    /// order. Throws std::bad_alloc.
    void test(const Point* points, std::uint32_t count, Vector<std::uint32_t>& inside);
    /// From here on test() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { pace_.follow(host); }

private:
    struct Query {
        Winding winding;
        std::uint32_t number = 0;
    };
    static bool lower(const Query& a, const Query& b) noexcept { return a.winding.query().y < b.winding.query().y; }
    QuerySteps sort_by_step();
    void sort_long_steps();
    void add_edges(const QuerySteps& steps, const Point* points, std::uint32_t count);
    void add_edge(Point a, Point b, std::uint32_t begin, std::uint32_t end);

    SiftEdges sift_edges_;
    Vector<Query> queries_, by_y_;
    Vector<std::uint32_t> ends_;  // of by_y_; see QuerySteps
    StopPace pace_;
};

}  // namespace lamella::nesting
