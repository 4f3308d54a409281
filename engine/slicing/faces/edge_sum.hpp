// The border of many rings that share edges: the sum of their directed edges, where an edge and its opposite cancel.
//
//     .--->---.  .--->---.       .--->-------->---.
//     |   a   |  |   b   |       |                |
//     ^       v  ^       v   =   ^                v      One edge of a ran down where one of b ran up.
//     |       |  |       |       |                |
//     '---<---'  '---<---'       '---<--------<---'
//
// Every ring leaves a point as often as it enters it, and so does the sum. Sorted by the point that they leave and by the
// one that they enter, the edges therefore have the same points at the same places: the edge at a place of the second order
// is followed by the one at that place of the first. Which of several edges follows at a point makes no difference to
// winding numbers, nor to the bytes of a region, as contours that meet are cut there.
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/order.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread.
class EdgeSum {
public:
    explicit EdgeSum(Worker& worker) noexcept : worker_(worker) {}

    /// Begins anew, for about so many edges that differ.
    void begin(std::size_t edges);
    /// Adds the edges of a closed ring; those without length count for nothing.
    void add(std::span<const Point> ring);
    /// Strings together what is left: O(e) for e edges. Throws std::bad_alloc, and Stopped where the host wants the call to
    /// end; so do the others.
    void link();

    /// After link(): the rings' points, one ring after the other, and where each ends.
    std::span<const Point> points() const noexcept { return points_; }
    std::span<const std::size_t> ring_ends() const noexcept { return ring_ends_; }

private:
    /// An edge and how often it runs from `low` to `high`, less how often the other way. Equal points: an unused place.
    struct Entry {
        Point low;
        Point high;
        std::int64_t times;
    };
    struct DirectedEdge {
        Point from;
        Point to;
    };

    Entry& place_of(Point low, Point high) noexcept;
    void add(Point from, Point to);
    void resize(std::size_t size);
    void grow();
    void collect();
    void sort_ends();

    Worker& worker_;
    Vector<Entry> table_{worker_.memory()};  // open addressing, at most three quarters full
    std::size_t used_ = 0;
    int shift_ = 0;  // from a hash to a place
    Vector<DirectedEdge> edges_{worker_.memory()};
    Vector<nesting::SortKey> leaving_{worker_.memory()};   // edges by the point that they leave
    Vector<nesting::SortKey> entering_{worker_.memory()};  // by the one that they enter
    Vector<nesting::SortKey> spare_{worker_.memory()};
    Vector<std::uint32_t> next_{worker_.memory()};  // of each edge, until it is in a ring
    Vector<Point> points_{worker_.memory()};
    Vector<std::size_t> ring_ends_{worker_.memory()};
};

}  // namespace lamella
