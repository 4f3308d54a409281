// A layer's paths cut into runs that are monotone in x and in y, and the pairs of runs whose boxes meet. A run does not meet
// itself, and the box of any stretch of it is the box of the stretch's two ends. Runs are found by upright strips of the
// layer, each of which holds those that reach into it:
//
//      |  ____   |
//      | /   |\  |         four runs; the upper two meet in their joint, and reach into two strips each
//      |/    | \ |
//      |\    | / |
//      | \___|/  |
//      |     |   |
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "audit/run_kernels.hpp"
#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/result.hpp"
#include "slicing/nesting/strips.hpp"

namespace lamella {

/// A contour's points one after the other among those of its layer: the edges' starts, and two points more, which are the
/// first two of a closed path.
struct LayerPath {
    std::size_t begin;  ///< edges [begin, end) of the layer; edge e leads from point e to point e + 1
    std::size_t end;
    std::uint64_t contour;
    bool closed;

    /// Whether there is an edge after edge `e`.
    bool goes_on(std::size_t e) const noexcept { return closed || e + 1 < end; }
};

/// Edges [begin, end) of a path.
struct EdgeRun {
    FlatBox box;
    std::size_t begin;
    std::size_t end;
    std::uint32_t path;
};

/// The runs of one layer after another; its memory is kept.
class EdgeRuns {
public:
    /// In a few calls of run(), which give the same on any number of threads. Throws std::bad_alloc.
    void assign(const SliceResult& result, const Layer& layer, const Parallel& parallel);

    std::uint64_t edges() const noexcept { return edges_; }
    const Point* points() const noexcept { return points_.data(); }
    const LayerPath& path_of(const EdgeRun& run) const noexcept { return paths_[run.path]; }
    /// Path by path, each from its start.
    std::span<const EdgeRun> runs() const noexcept { return runs_.span(); }

    std::size_t strips() const noexcept { return firsts_.empty() ? 0 : firsts_.size() - 1; }
    /// Where a strip begins.
    std::int32_t left_of(std::size_t strip) const noexcept {
        return static_cast<std::int32_t>(low_ + (static_cast<std::int64_t>(strip) << shift_));
    }
    /// What stands in a strip: [first, second), as indices into boxes(), ordered by low_y.
    std::pair<std::size_t, std::size_t> entries_of(std::size_t strip) const noexcept {
        return {firsts_[strip], firsts_[strip + 1]};
    }
    /// Cuts the strips into `shares` that hold about as much each: where one begins.
    std::size_t first_strip_of(std::size_t share, std::size_t shares) const noexcept;

    BoxArrays boxes() const noexcept {
        return {low_x_.data(), low_y_.data(), high_x_.data(), high_y_.data(), run_at_.data()};
    }

private:
    /// Of a path: few enough edges for one task.
    struct Piece {
        std::uint32_t path;
        std::size_t begin;
        std::size_t end;
    };
    /// What a task works with.
    struct Scratch {
        std::vector<std::uint32_t> turns;
        std::vector<EdgeRun> runs;
    };

    std::size_t strip_of(std::int32_t x) const noexcept {
        return static_cast<std::size_t>((std::int64_t{x} - low_) >> shift_);
    }
    void list_pieces(const SliceResult& result, const Layer& layer);
    void copy_points(const SliceResult& result, const Piece& piece);
    void cut(const Piece& piece, Scratch& scratch) const;
    void join_runs(const Parallel& parallel);
    void order_runs(const Parallel& parallel);
    void order_few();
    void choose_strips();
    void fill_strips(const Parallel& parallel);

    std::vector<LayerPath> paths_;
    std::vector<Piece> pieces_;
    std::vector<std::size_t> tasks_;  // first piece of each, and the number of pieces
    std::vector<Scratch> scratch_;    // by task
    Array<Point> points_;
    Array<EdgeRun> runs_;
    std::vector<std::uint64_t> order_;  // of runs by low.y; the lower 32 bits are a run's index
    std::vector<std::uint64_t> unordered_;
    std::vector<std::uint32_t> places_;  // by bucket of low.y
    std::size_t edges_ = 0;
    std::int64_t low_ = 0;
    int shift_ = 0;
    std::vector<std::size_t> firsts_;   // of each strip, and the end of the last
    std::vector<std::size_t> cursors_;  // by range of runs and strip: first a count, then where the next run goes
    Array<std::int32_t> low_x_;
    Array<std::int32_t> low_y_;
    Array<std::int32_t> high_x_;
    Array<std::int32_t> high_y_;
    Array<std::uint32_t> run_at_;
};

}  // namespace lamella
