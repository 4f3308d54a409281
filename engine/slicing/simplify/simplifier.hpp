// Contours of a layer with fewer points, which lie within a tolerance of those that they had.
//
//     reduce      each contour by itself, by the algorithm of Douglas and Peucker: of a chain the furthest point is kept,
//                 and the two parts are looked at again, until a line replaces the chain within the tolerance
//     conflicts   lines that may not stay, among those of all contours
//     give_back   these are split again, in each round into twice as many, and reduced, until none is left
//
//          ____                 ____
//        _/    \_             /      \         five points of a chain go,
//       /        \    ->     /        \        four are kept
//
// A line is in conflict where it
//
//     meets       another edge elsewhere than in the joint of two that follow each other: it would cross or touch. Where
//                 contours met before, they keep their points
//     jumps       over the start of another contour, which would then lie on its other side. As no two meet, the start
//                 stands for the whole contour
//     turns       the contour: of all its lines together, if its area would vanish or change its sign
//
// No conflict depends on the order of contours, and no decision on rounding. A chain of n points is whole again after about
// log2 n rounds, so that the rounds end. Contours start where they did.
//
// A round takes O(m log m) steps for m points, unless edges come close, or starts lie in boxes of chains, far more often
// than there are points. Where it would take more than 64 m (log2 m + 2), the layer stays as it is: that is decided by a
// count of steps, not by time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/grid/box_tree.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

// Chains of a contour's edges and the lines that would replace them: how far they lie apart, what they meet and what lies
// between them. By integers alone.

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

/// Simplifies layer after layer; scratch is kept. One per thread.
class Simplifier {
public:
    explicit Simplifier(Worker& worker) noexcept : worker_(worker) {}

    /// Takes points off `items`: points, count, start, area and box of those that lose some become others, which stay until
    /// the next call. Contours that are flat stay; closed ones keep three points and the sign of their area, open ones their
    /// ends. Origins, of all items or none, follow their points; a line that replaces points comes from no triangle.
    /// `tolerance` is in grid units, above 0. O(m log^2 m) for m points. Throws std::bad_alloc.
    void run(std::span<NestItem> items, std::int64_t tolerance);

    /// After run(): the points of item `item` that are left, as numbers from its start on.
    std::span<const std::uint32_t> left_of(std::size_t item) const noexcept {
        return std::span(left_).subspan(paths_[item].first_left, paths_[item].left);
    }

private:
    /// An item. Its points among points_: [begin, last], of a closed one with its start at both ends.
    struct Reduction {
        std::size_t begin = 0;
        std::size_t last = 0;        ///< where its last edge ends
        std::size_t first_left = 0;  ///< in left_ and left_points_
        std::size_t left = 0;
        bool closed = false;
        bool stays = false;        ///< as it is
        bool has_changed = false;  ///< since conflicts were sought

        std::size_t count() const noexcept { return last - begin + (closed ? 0 : 1); }
    };
    using Index = std::uint32_t;

    void list(std::span<const NestItem> items);
    void reduce(Reduction& path);
    void reduce_chain(std::size_t first, std::size_t last);
    void reduce_chain(std::size_t first, std::size_t last, int splits_left);
    void list_left();
    bool find_conflicts(std::span<const NestItem> items);
    void compare(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j);
    void find_jumps(std::size_t path, std::uint64_t most);
    void keep_orientation(std::size_t path, const NestItem& item);
    bool is_line(std::size_t path, std::size_t edge) const noexcept;
    std::size_t end_of_line(std::size_t path, std::size_t edge) const noexcept;
    void object_to(std::size_t path, std::size_t edge) noexcept;
    bool give_back(int round);
    void split(std::size_t first, std::size_t last, int times, bool by_halves);
    void write(std::span<NestItem> items);
    void write_origins(std::size_t path, const NestItem& item) noexcept;

    Worker& worker_;
    std::int64_t tolerance_ = 0;
    Vector<Reduction> paths_{worker_.memory()};           // of each item
    Vector<Point> points_{worker_.memory()};              // of all paths, from their starts
    Vector<std::uint8_t> is_left_{worker_.memory()};      // of points_
    Vector<std::uint8_t> in_conflict_{worker_.memory()};  // of points_: the line that begins there
    Vector<Index> left_{worker_.memory()};                // numbers of the points that are left, path by path
    Vector<Point> left_points_{worker_.memory()};         // the same points
    Vector<PointOrigin> left_origins_{worker_.memory()};  // of left_points_, where items have origins
    Vector<Point> starts_{worker_.memory()};              // of paths_
    PointTree starts_tree_{worker_};
    ChainTree chains_{worker_.memory()};  // of points_
    std::uint64_t steps_ = 0;             // in search of jumps, in a round
    EdgePairs pairs_{worker_};
};

}  // namespace lamella
