// Orientation and nesting of one layer (step 4 of the paper's Fig. 1).
//
// The parent of a closed contour is the smallest closed contour (by |area|, ties by start, box and points) whose non-zero
// winding interior strictly contains its start point. All tests are exact: box tests choose candidates, integer products
// decide.
//
// Parent chains cannot cycle, even where contours cross. A contour's start is the smallest (x, y) of its convex hull, so
// every point strictly inside is larger, and starts strictly decrease from child to parent.
//
// Contours are visited from small to large. Each becomes the parent of the starts strictly inside it that have none yet. The
// starts in its box are found by x, or where boxes are wide in a tree; starts with a parent are taken off. A nest of any
// depth thus costs one test a contour. Starts in the box of one contour are tested together.
//
// O(q log q) for q contours and points, also for deep nests and for arrays of separate contours. Two cases cost more. A
// start inside the boxes of k contours, but not inside the contours, costs O(k) (L shapes nested in each other's corner).
// A box that is long and thin meets up to the square root of q nodes of the tree.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>

#include "base/function_ref.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "lamella/layers.hpp"
#include "lamella/result.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/nesting/inside.hpp"
#include "slicing/nesting/order.hpp"
#include "slicing/nesting/starts.hpp"

namespace lamella {

// Origins of the edges of a contour while it is rotated, turned round, joined and cut. origins[i] is of the edge from point
// i to the next one; at the end of an open polyline, of the point alone.

/// Of the edge walked the other way.
constexpr PointOrigin turned(PointOrigin origin) noexcept {
    std::swap(origin.edge, origin.end_edge);
    return origin;
}

/// Of the last point of an open polyline, by the edge that ends there.
constexpr PointOrigin end_of(const PointOrigin& last) noexcept {
    return {last.triangle, last.part, last.end_edge, no_edge};
}

/// Of a stretch of an edge: its ends are those of the whole, or are made.
constexpr PointOrigin stretch_of(PointOrigin whole, bool from_begin, bool to_end) noexcept {
    whole.edge = from_begin ? whole.edge : no_edge;
    whole.end_edge = to_end ? whole.end_edge : no_edge;
    return whole;
}

/// Of what is made of two edges: the smallest part, then the smallest triangle. An edge from none is the larger.
constexpr PointOrigin origin_of_both(const PointOrigin& a, const PointOrigin& b) noexcept {
    if (a.triangle == no_triangle || b.triangle == no_triangle) {
        return b.triangle == no_triangle ? a : b;
    }
    return a.part != b.part ? (a.part < b.part ? a : b) : std::min(a, b);
}

/// One contour of a layer: input and output of nesting.
struct NestItem {
    const Point* points = nullptr;  ///< consecutive ones distinct; closed: the first is not repeated; any may come first
    const PointOrigin* origins = nullptr;  ///< of each point; null: none. Nesting does not look at them
    std::uint32_t count = 0;
    std::uint32_t start = 0;  ///< closed: index of its smallest (x, y)
    Integer128 twice_area{};  ///< closed: as walked, square grid units
    FlatBox box{};            ///< closed: of its points
    bool closed = false;

    bool reverse = false;         ///< out: the points must be stored backwards (outer counter-clockwise, hole clockwise)
    std::int8_t orientation = 0;  ///< out: sign of the area; 0 for flat and open
    Role role = Role::open;       ///< out
    std::uint16_t flags = 0;      ///< out: orientation_overruled is added to what is there
    std::int32_t parent = -1;     ///< out: index of an item, -1 for none
    std::uint32_t part = 0;       ///< as Contour::part; nesting does not look at it

    /// The i-th point from the start on, as walked.
    const Point& from_start(std::uint32_t i) const noexcept { return points[(start + i) % count]; }
    /// Where the edge from there on comes from; none where there are no origins.
    PointOrigin origin_from_start(std::uint32_t i) const noexcept {
        return origins == nullptr ? PointOrigin() : origins[(start + i) % count];
    }
    /// Resets the outputs to those of a contour by itself: role flat or open, and its orientation.
    void reset() noexcept;
};

/// The Contour::part of a contour made of two.
constexpr std::uint32_t part_of_both(std::uint32_t a, std::uint32_t b) noexcept {
    return a == b ? a : several_parts;
}

/// Twice the area, whichever way the contour runs.
Int128 size_of(const NestItem& item) noexcept;

/// By the number of points, then by the points from the starts on.
std::strong_ordering compare_points(const NestItem& a, const NestItem& b) noexcept;

}  // namespace lamella

namespace lamella::nesting {

/// A closed contour with area. Rings are in the order of starts, of equal ones the smaller first: a parent comes before its
/// children.
struct Ring {
    std::uint32_t item = 0;
    std::uint32_t right = 0;   // the first ring that starts right of this one
    std::int32_t parent = -1;  // index of a ring
    std::int32_t winding = 0;  // winding number just inside
    std::uint32_t depth = 0;   // number of rings around
    bool overruled = false;    // this or an enclosing ring has a winding number below zero
};

}  // namespace lamella::nesting

namespace lamella {

/// Nests layer after layer; scratch is kept, so that a steady state allocates nothing. One per thread.
class Nester {
public:
    explicit Nester(Worker& worker) noexcept : worker_(worker) {}

    /// Fills in the outputs of `items`, which are at most 2^31 - 1. Outputs do not depend on the order of the items, except
    /// that of contours equal in every point the first is the parent. Throws std::bad_alloc.
    void nest(std::span<NestItem> items);

private:
    void collect(std::span<NestItem> items);
    void reserve_keys(std::size_t count);
    void sort_by_start(std::span<const NestItem> items);
    void find_parents(std::span<const NestItem> items);
    Point start_of(std::size_t ring) const noexcept { return nesting::point_of(by_start_[ring].key); }
    void list_containers(std::span<const NestItem> items);
    void sort_by_size(std::span<const NestItem> items);
    void take_in(const NestItem& contour, std::uint32_t ring);
    void adopt(std::uint32_t ring, std::uint32_t child);
    void assign_roles(std::span<NestItem> items);

    Worker& worker_;
    nesting::AddEdges add_edges_ = best_of(nesting::add_edges_forms(), worker_.instructions());
    Vector<nesting::SortKey> by_start_{worker_.memory()};  // of rings_: their starts
    Vector<nesting::SortKey> by_size_{worker_.memory()};   // of rings_ that may have children: their areas
    Vector<nesting::SortKey> spare_keys_{worker_.memory()};
    Vector<nesting::Ring> rings_{worker_.memory()};
    nesting::StartLine starts_{worker_.memory()};  // of rings_ that have no parent yet
    PointTree tree_{worker_};                      // of the same, where boxes are wide
    bool in_tree_ = false;
    Vector<std::uint32_t> found_{worker_.memory()};  // rings with starts in a contour's box
    nesting::ManyInside many_inside_{worker_};
};

// A contour of a layer from the walk, or wherever else it comes from, until it is appended to the band's output.

/// It is no Contour, which has a place in a result, and neither a start nor a key. A NestItem is the part of it that the
/// search for parents reads again and again.
struct Path {
    NestItem item;               ///< points, area and box; then what nesting decides
    EndKey start_key{};          ///< the edge that the start lies on; zero where the contour was joined or made
    std::uint32_t segments = 0;  ///< triangles that it crosses; of a contour that was made its edges
    bool made = false;           ///< by a fill rule or an offset, of one contour or several
    bool hole = false;           ///< of a region: clockwise in the result
    std::uint32_t source = 0;    ///< of an offset curve: index of the path that was moved
    std::int64_t touched = -1;   ///< of a region: see Arrangement::trace()
    bool is_backward() const noexcept { return (to_int128(item.twice_area) > 0) == hole; }  ///< of a region: solid right
};

/// The edge that the i-th point of a contour lies on.
using KeyAt = FunctionRef<EndKey(std::uint32_t)>;

/// A closed contour for nesting from its points alone, at least one. `origins`: of each point, or null. O(points).
NestItem closed_item(std::span<const Point> points, const PointOrigin* origins = nullptr, std::uint32_t part = 0) noexcept;

/// A closed contour of `count` points. Its start is the smallest (x, y, edge key); where the contour passes through one edge
/// twice, the smaller of the two rotations, by points and then by origins. If consecutive points are equal, the ring is
/// rewritten without repeats. `origins`: of each point, or null.
Path closed_path(Point* ring, std::uint32_t count, const RingFacts& facts, KeyAt key_at, PointOrigin* origins);

/// A closed contour whose points lie on no mesh edge.
Path closed_path(std::span<Point> ring, PointOrigin* origins);

/// An open contour. One of equal consecutive points is kept.
Path open_path(std::span<Point> points, PointOrigin* origins);

/// By the start point, then by its edge, then by content, origins last: contours equal in all of that are interchangeable.
bool comes_before(const Path& path_a, const Path& path_b);
/// Points, and their origins unless null, of a contour walked the other way. A closed one keeps the origin of the edge that
/// closes it.
void turn_round(std::span<Point> points, PointOrigin* origins, bool closed);

/// A contour of a caller's own, of which a layer is to be built: its points and origins are copied.
inline Path given_path(std::span<const Point> points, const PointOrigin* origins = nullptr, bool closed = true) noexcept {
    const auto count = static_cast<std::uint32_t>(points.size());
    return {.item = {.points = points.data(), .origins = origins, .count = count, .closed = closed}, .segments = count};
}

}  // namespace lamella
