// Whether the ring of a chain and the line back encloses a point, without a look at each edge.
//
// A stretch of the chain whose box does not hold the point winds around it as the straight line between the stretch's ends
// does: both lie in the box, and the point outside. So only boxes that hold the point are opened. Boxes are of 8 edges, of
// two such boxes, and so on:
//
//     level 1   [      0      ][      1    ]
//     level 0   [  0  ][  1  ][  2  ][  3  ]
//     edges     01234567 ...
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/edges/flat_box.hpp"

namespace lamella {

/// Of one layer after another; its memory is kept.
class ChainTree {
public:
    explicit ChainTree(const Memory* memory) : boxes_(memory), levels_(memory) {}

    /// Edge i leads from points[i] to points[i + 1]. The points must stay. O(n). Throws std::bad_alloc.
    void build(std::span<const Point> points, StopPace& pace);

    /// Whether `p` lies on the chain from points[first] to points[last], or within the ring of it and the line back; not
    /// where it is one of these two points. `steps` grows by the boxes and edges looked at: O(log n) where those at each
    /// level lie apart, O(n) at worst.
    bool encloses(std::size_t first, std::size_t last, Point p, std::uint64_t& steps) const;

private:
    struct Query;
    void visit(std::size_t level, std::size_t at, Query& query) const;

    std::span<const Point> points_;
    Vector<FlatBox> boxes_;       // level by level
    Vector<std::size_t> levels_;  // where each level begins in boxes_, and the end
};

}  // namespace lamella
