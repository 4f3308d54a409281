// Chains of a contour's edges and the lines that would replace them: how far they lie apart, what they meet and what lies
// between them. By integers alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/box.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Measured over the points strictly between the ends of a chain.
struct ChainReach {
    std::size_t furthest;  ///< index of one to keep, should the chain be split
    bool within;           ///< all lie within the tolerance of the line between the ends
};

/// Measures points[first] to points[last], last > first + 1. Distances are to the line from end to end, which stops there; a
/// line between equal ends replaces nothing. `tolerance` is in grid units, at most 2 grid_limit. O(last - first).
ChainReach measure_chain(const Point* points, std::size_t first, std::size_t last, std::int64_t tolerance) noexcept;

inline bool lies_on(Point p, Point a, Point b) noexcept {
    return FlatBox::around(a, b).holds(p) && side_of(a, b, p) == 0;
}

/// True if two edges have a point in common.
inline bool have_common_point(Point a, Point b, Point c, Point d) noexcept {
    return edges_cross(a, b, c, d) || lies_on(a, c, d) || lies_on(b, c, d) || lies_on(c, a, b) || lies_on(d, a, b);
}

/// True if one of two edges that follow each other lies on the other.
inline bool folds_back(Point from, Point joint, Point to) noexcept {
    return lies_on(from, joint, to) || lies_on(to, from, joint);
}

/// The share of an edge in the winding number of a closed path around `p`, which does not lie on it.
inline int winding_of(Point from, Point to, Point p) noexcept {
    if ((from.y <= p.y) == (to.y <= p.y)) {
        return 0;
    }
    const int side = side_of(from, to, p);
    return from.y <= p.y ? (side > 0 ? 1 : 0) : (side < 0 ? -1 : 0);
}

/// True if the ring of a chain and the line back encloses a point, without a look at each edge: a stretch of the chain whose
/// box does not hold the point winds around it as the straight line between the stretch's ends does, as both lie in the box
/// and the point outside. So only boxes that hold the point are opened. Its memory is kept.
class ChainTree {
public:
    explicit ChainTree(const Memory* memory) : boxes_(memory) {}

    /// Edge i leads from points[i] to points[i + 1]. The points must stay. O(n). Throws std::bad_alloc.
    void build(std::span<const Point> points, StopPace& pace);

    /// True if `p` lies on the chain from points[first] to points[last], or within the ring of it and the line back; not
    /// where it is one of these two points. `steps` grows by the boxes and edges looked at: O(log n) where those at each
    /// level lie apart, O(n) at worst.
    bool encloses(std::size_t first, std::size_t last, Point p, std::uint64_t& steps) const;

private:
    struct Query;
    void visit(std::size_t level, std::size_t number, Query& query) const;
    void visit_edges(std::size_t begin, std::size_t end, Query& query) const;

    std::span<const Point> points_;
    BoxTree<Point> boxes_;
};

}  // namespace lamella
