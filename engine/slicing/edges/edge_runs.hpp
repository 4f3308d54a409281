// A layer's paths cut into runs that are monotone in x and in y. A run does not meet itself, and the box of any stretch of
// it is the box of the stretch's two ends.
//
//          ____
//         /    \          four runs, and the boxes of two stretches of the lower left one
//       _/      \_        .
//      |          |       .
//       \_      _/        .
//         \____/
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/array.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

// Where a path turns: the loop of the search for edges near one another that goes through all of them.

/// There is room for so many points after the last.
constexpr std::size_t turn_lanes = 32;

/// Writes the edges before which a path turns: which goes left where one since the last turn went right, or down where one
/// went up, or the other way round. Edge i leads from points[i] to points[i + 1]. Returns how many; `out` has room for
/// `edges`.
using FindTurns = std::size_t (*)(const Point* points, std::size_t edges, std::uint32_t* out);

std::span<const Form<FindTurns>> find_turns_forms() noexcept;

/// A contour's points one after the other, from its start to its start again if it is closed.
struct EdgePath {
    std::span<const Point> points;
    std::uint64_t contour = 0;
    bool closed = true;
    std::size_t start = 0;  ///< an index of points; 0 if open
    Point place{};          ///< in paths(): between its start and the point half its edges away
    /// In paths(): edges [begin, end) of the layer; edge e leads from point e to point e + 1. After the edges' starts come
    /// two points more, which are the first two of a closed path.
    std::size_t begin = 0;
    std::size_t end = 0;

    std::size_t edges() const noexcept { return points.size() < 2 ? 0 : (closed ? points.size() : points.size() - 1); }
    /// `at` may lie up to a round beyond the last.
    Point operator[](std::size_t at) const noexcept {
        at = at < points.size() ? at : at - points.size();
        return points[at + start < points.size() ? at + start : at + start - points.size()];
    }
    /// True if there is an edge after edge `e` of the layer.
    bool goes_on(std::size_t e) const noexcept { return closed || e + 1 < end; }
};

/// Edges [begin, end) of a path.
struct EdgeRun {
    FlatBox box;
    std::size_t begin;
    std::size_t end;
    std::uint32_t path;
};

/// The runs of one layer after another, and a tree of their boxes; its memory is kept. O(m + p log p) for p
/// paths with m edges.
class EdgeRuns {
public:
    explicit EdgeRuns(Worker& worker) noexcept : worker_(worker) {}

    /// No paths.
    void clear() noexcept;
    /// Lists a path for cut(). Throws std::bad_alloc.
    void add(const EdgePath& path);
    /// Cuts the paths into runs. Boxes in the tree meet where those of the runs come within `margin` of each other, which is
    /// below grid_limit. `parallel`: a few calls of run(), which give the same on any number of threads; null: on this
    /// thread. Throws std::bad_alloc.
    void cut(std::int32_t margin, const Parallel* parallel = nullptr);

    std::uint64_t edges() const noexcept { return edges_; }
    const Point* points() const noexcept { return points_.data(); }
    /// The point that edge `e` of a path leaves, from its start; up to two after its last.
    Point point(const EdgePath& path, std::size_t e) const noexcept { return points_[path.begin + e]; }
    std::span<const EdgePath> paths() const noexcept { return paths_; }
    const EdgePath& path_of(const EdgeRun& run) const noexcept { return paths_[run.path]; }
    /// Path by path, each from its start.
    std::span<const EdgeRun> runs() const noexcept { return runs_.span(); }
    /// Of the runs.
    const BoxTree<Point>& boxes() const noexcept { return boxes_; }
    std::int32_t margin() const noexcept { return margin_; }

private:
    /// A stretch of a path: few enough edges for one task.
    struct Piece {
        std::uint32_t path;
        std::size_t begin;
        std::size_t end;
        std::size_t turns;
        std::size_t first_run;
    };

    void order_paths();
    void list_pieces();
    void copy_points(const Piece& piece) noexcept;
    void find_turns(Piece& piece) noexcept;
    void number_runs();
    void write_runs(const Piece& piece) noexcept;

    Worker& worker_;
    const FindTurns find_turns_ = best_of(find_turns_forms(), worker_.instructions());
    std::int32_t margin_ = 0;
    Vector<EdgePath> paths_{worker_.memory()};
    std::uint64_t edges_ = 0;
    std::size_t point_count_ = 0;  // with two more of each path
    Array<Point> points_{worker_.memory()};
    Array<std::uint32_t> turns_{worker_.memory()};  // of a piece from its first edge on
    Array<EdgeRun> runs_{worker_.memory()};
    Vector<Piece> pieces_{worker_.memory()};
    BoxTree<Point> boxes_{worker_.memory()};  // of runs_, of which neighbours lie close
};

}  // namespace lamella
