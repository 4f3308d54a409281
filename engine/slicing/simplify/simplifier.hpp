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
#include "slicing/nesting/nest.hpp"

namespace lamella {

/// Simplifies layer after layer; scratch is kept. One per thread.
class Simplifier {
public:
    explicit Simplifier(Worker& worker) noexcept : worker_(worker) {}

    /// Takes points off `items`: points, count, start, area and box of those that lose some become others, which stay until
    /// the next call. Contours that are flat stay; closed ones keep three points and the sign of their area, open ones their
    /// ends. Origins, of all items or none, follow their points; a line that replaces points comes from no triangle.
    /// `tolerance` is in grid units, above 0. O(m log^2 m) for m points. Throws std::bad_alloc.
    void run(std::span<NestItem> items, std::int64_t tolerance);

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
    /// The start of another path that may lie between a chain and its line.
    struct Beside {
        Point start;
        int winding = 0;  ///< of the ring of both around it
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
    void list_beside(std::size_t path, std::size_t first, std::size_t last, std::uint64_t most);
    bool jumps_over_any(std::size_t first, std::size_t last, std::uint64_t most);
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
    Vector<Beside> beside_{worker_.memory()};
    std::uint64_t steps_ = 0;  // in search of jumps, in a round
    EdgePairs pairs_{worker_};
};

}  // namespace lamella
