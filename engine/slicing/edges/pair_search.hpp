// The pairs of edges that come near one another, of a layer's runs: runs whose boxes meet in their tree are halved until
// a few edges are left, which are compared at once. O(r log r + c) for r runs whose boxes lie apart and c pairs of edges
// with close boxes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/edges/edge_runs.hpp"

namespace lamella {

/// Searches one layer, or one share of a layer, after another; its memory is kept. Several may search the same layer.
class PairSearch {
public:
    explicit PairSearch(Worker& worker) noexcept : worker_(worker) {}

    /// To be called in `meet`: find() ends, and returns false.
    void stop() noexcept { cut_short_ = true; }
    /// To be called in `meet`: find() may take so many steps more.
    void allow(std::uint64_t steps) noexcept { most_steps_ += steps; }

    /// Share `share` of `shares` of all pairs. Calls meet(a, i, b, j) once for each pair, in no order, of edge i of path a
    /// and edge j of path b whose boxes come within the runs' margin of each other: all such pairs of two paths, and of one
    /// path all of different runs but the last and first edge of two successive runs that lead away from their joint. Paths
    /// are those of `runs`, edges those of the layer. The run of edge i comes before that of edge j. False if it would take
    /// more than `most_steps`, and not all were found. Throws std::bad_alloc.
    template <class Meet>
    bool find(const EdgeRuns& runs, std::size_t share, std::size_t shares, std::uint64_t most_steps, Meet meet) {
        layer_ = &runs;
        points_ = runs.points();
        most_steps_ = most_steps;
        steps_ = 0;
        cut_short_ = false;
        const BoxTree<Point>& boxes = runs.boxes();
        const std::size_t last = boxes.groups() * (share + 1) / shares;
        for (std::size_t group = boxes.groups() * share / shares; group < last && !cut_short_; ++group) {
            const std::size_t first = boxes.group_begin(group);
            const std::size_t cost = boxes.search_pairs(group, no_limit, [&](std::size_t other, LaneBits met) {
                each_lane(met, [&](std::size_t lane) { compare_runs(runs.runs()[first + lane], runs.runs()[other], meet); });
            });
            spend(1 + cost / BoxTree<Point>::visit_cost);
        }
        return !cut_short_;
    }

    /// Steps of the last call.
    std::uint64_t steps() const noexcept { return steps_; }

private:
    static constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max();
    static constexpr std::size_t few = BoxBlock<Point>::lanes;

    /// Part of a run.
    struct Stretch {
        FlatBox box;
        std::size_t begin;
        std::size_t end;
    };

    void spend(std::uint64_t steps) {
        steps_ += steps;
        worker_.spend(steps);
        cut_short_ = cut_short_ || steps_ > most_steps_;
    }

    bool leads_into(const EdgeRun& run, const EdgeRun& next) const noexcept {
        if (run.path != next.path) {
            return false;
        }
        const EdgePath& path = layer_->path_of(run);
        return run.end == next.begin || (path.closed && run.end == path.end && next.begin == path.begin);
    }

    /// True if `next`, which follows `run`, comes within the margin of it in their joint alone: one direction goes on, and
    /// the two edges at the joint lead so far away in it.
    bool leads_away(const EdgeRun& run, const EdgeRun& next) const noexcept {
        const Point before = points_[run.end - 1];
        const Point joint = points_[run.end];
        const Point after = points_[next.begin + 1];
        const auto goes_on = [margin = std::int64_t{layer_->margin()}](std::int64_t a, std::int64_t b, std::int64_t c) {
            return (b - a > margin && c - b > margin) || (a - b > margin && b - c > margin);
        };
        return goes_on(before.x, joint.x, after.x) || goes_on(before.y, joint.y, after.y);
    }

    template <class Meet>
    void compare_runs(const EdgeRun& a, const EdgeRun& b, Meet& meet) {
        const bool apart = (leads_into(a, b) && leads_away(a, b)) || (leads_into(b, a) && leads_away(b, a));
        if (!apart && !cut_short_) {
            compare({a.box, a.begin, a.end}, {b.box, b.begin, b.end}, a.path, b.path, meet);
        }
    }

    /// Halves the longer until both have a few edges. As deep as the logarithms of their lengths.
    template <class Meet>
    void compare(const Stretch& a, const Stretch& b, std::uint32_t a_path, std::uint32_t b_path, Meet& meet) {
        spend(1);
        if (cut_short_ || !grown(a.box, layer_->margin()).meets(b.box)) {
            return;
        }
        const std::size_t a_edges = a.end - a.begin;
        const std::size_t b_edges = b.end - b.begin;
        if (std::max(a_edges, b_edges) <= 2 * few) {
            compare_edges(a, b, [&](std::size_t i, std::size_t j) { meet(a_path, i, b_path, j); });
        } else if (a_edges >= b_edges) {
            compare(part(a.begin, a.begin + a_edges / 2), b, a_path, b_path, meet);
            compare(part(a.begin + a_edges / 2, a.end), b, a_path, b_path, meet);
        } else {
            compare(a, part(b.begin, b.begin + b_edges / 2), a_path, b_path, meet);
            compare(a, part(b.begin + b_edges / 2, b.end), a_path, b_path, meet);
        }
    }

    /// Each edge of `a` with up to eight of `b` at once.
    template <class Met>
    void compare_edges(const Stretch& a, const Stretch& b, const Met& met) {
        for (std::size_t first = b.begin; first < b.end; first += few) {
            BoxBlock<Point> boxes;
            boxes.set_edges(points_ + first);  // after the last point there is room
            const LaneBits used = all_eight >> (few - std::min(few, b.end - first));
            spend(a.end - a.begin);
            for (std::size_t i = a.begin; i < a.end; ++i) {
                const FlatBox near = grown(FlatBox::around(points_[i], points_[i + 1]), layer_->margin());
                each_lane(boxes.meets(near) & used, [&](std::size_t lane) {
                    if (!cut_short_) {
                        met(i, first + lane);
                    }
                });
            }
        }
    }

    Stretch part(std::size_t begin, std::size_t end) const noexcept {
        return {FlatBox::around(points_[begin], points_[end]), begin, end};
    }

    Worker& worker_;
    const EdgeRuns* layer_ = nullptr;
    const Point* points_ = nullptr;
    std::uint64_t most_steps_ = 0;
    std::uint64_t steps_ = 0;
    bool cut_short_ = false;
};

/// Pairs of edges of paths in a plane, on one thread. Searches one layer after another; its memory is kept.
class EdgePairs : public EdgeRuns {
public:
    explicit EdgePairs(Worker& worker) noexcept : EdgeRuns(worker), search_(worker) {}

    /// To be called in `meet`: find() ends, and returns false.
    void stop() noexcept { search_.stop(); }
    /// To be called in `meet`: find() may take so many steps more.
    void allow(std::uint64_t steps) noexcept { search_.allow(steps); }

    /// Calls meet(a, i, b, j) once for each pair, in no order, of edge i of path a and edge j of path b whose boxes come
    /// within `margin` of each other: of one path as PairSearch::find() says. Edge i leads from a[i] to a[i + 1]. `margin`
    /// is below grid_limit. The points added must stay until it has returned. False if it would take more than `steps`, and
    /// not all were found. Throws std::bad_alloc.
    template <class Meet>
    bool find(std::int32_t margin, std::uint64_t steps, Meet meet) {
        cut(margin);
        return search_.find(*this, 0, 1, steps, by_path(meet));
    }

    /// Calls `meet` as find() does, for what names paths by their numbers and edges by those of the layer. It must stay.
    template <class Meet>
    auto by_path(Meet& meet) const {
        return [this, &meet](std::uint32_t a, std::size_t i, std::uint32_t b, std::size_t j) {
            const EdgePath& a_path = paths()[a];
            const EdgePath& b_path = paths()[b];
            meet(a_path, i - a_path.begin, b_path, j - b_path.begin);
        };
    }

private:
    PairSearch search_;
};

}  // namespace lamella
