// Pairs of edges that come near one another, of paths in a plane. A path is cut into runs that are monotone in x and in y. A
// run does not meet itself, and the box of any stretch of it is the box of the stretch's two ends. Runs whose boxes meet are
// halved until single edges are left.
//
//          ____
//         /    \          four runs, and the boxes of two stretches of the lower left one
//       _/      \_        .
//      |          |       .
//       \_      _/        .
//         \____/
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "base/stop_pace.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/strips.hpp"

namespace lamella {

/// A contour's points one after the other, from its start to its start again if it is closed.
struct EdgePath {
    std::span<const Point> points;
    std::uint64_t contour = 0;
    bool closed = true;
    std::size_t start = 0;  ///< an index of points; 0 if open

    std::size_t edges() const noexcept { return points.size() < 2 ? 0 : (closed ? points.size() : points.size() - 1); }
    /// `at` may lie up to a round beyond the last.
    Point operator[](std::size_t at) const noexcept {
        at = at < points.size() ? at : at - points.size();
        return points[at + start < points.size() ? at + start : at + start - points.size()];
    }
    /// Whether there is an edge after edge `e`.
    bool goes_on(std::size_t e) const noexcept { return closed || e + 1 < edges(); }
};

/// Searches one layer after another; its memory is kept.
class EdgePairs {
public:
    void clear() {
        paths_.clear();
        runs_.clear();
        edges_ = 0;
    }

    /// Throws std::bad_alloc.
    void add(const EdgePath& path) {
        if (path.edges() > 0) {
            cut(path, static_cast<std::uint32_t>(paths_.size()));
            paths_.push_back(path);
            edges_ += path.edges();
        }
    }

    std::uint64_t edges() const noexcept { return edges_; }

    /// To be called in `meet`: find() ends, and returns false.
    void stop() noexcept { cut_short_ = true; }

    /// From here on find() throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept { host_ = host; }

    /// Calls meet(a, i, b, j) once for each pair, in no order, of edge i of path a and edge j of path b whose boxes come
    /// within `margin` of each other: all such pairs of two paths, and of one path all that meet elsewhere than in the joint
    /// of two runs, and some that do not. Edge i leads from a[i] to a[i + 1]. False if it would take more than `steps`, and
    /// not all were found. Throws std::bad_alloc.
    template <class Meet>
    bool find(std::int32_t margin, std::uint64_t steps, Meet meet) {
        if (runs_.empty()) {
            return true;
        }
        margin_ = margin;
        steps_left_ = steps;
        cut_short_ = false;
        StopPace pace;
        pace.follow(host_);
        std::sort(runs_.begin(), runs_.end(), [&pace](const Run& a, const Run& b) {
            pace.spend(1);
            return a.box.low.x < b.box.low.x;
        });
        begin_sweep();
        for (std::uint32_t r = 0; r < runs_.size() && !cut_short_; ++r) {
            const FlatBox box = runs_[r].box.grown(margin);
            spend(met_.visit(box, [&](std::uint32_t other) { compare_runs(runs_[other], runs_[r], meet); }));
            met_.add(runs_[r].box, r);
        }
        return !cut_short_;
    }

private:
    /// Edges [begin, end) of a path; edge e leads from point e to point e + 1.
    struct Run {
        std::uint32_t path;
        std::uint32_t begin;
        std::uint32_t end;
        int right;  ///< 1, -1, or 0 if all edges are upright
        int up;
        FlatBox box;

        /// Whether one direction goes on.
        bool goes_on_in(const Run& next) const noexcept { return right * next.right >= 0 || up * next.up >= 0; }
    };

    void spend(std::uint64_t steps) {
        constexpr std::uint32_t calls_between_stops = 4096;
        if (++calls_ % calls_between_stops == 0 && host_.stop_requested()) {
            throw Stopped();
        }
        cut_short_ = cut_short_ || steps > steps_left_;
        steps_left_ -= std::min(steps, steps_left_);
    }

    void begin_sweep() {
        FlatBox all = runs_[0].box;
        std::int64_t heights = 0;
        for (const Run& run : runs_) {
            all.low.y = std::min(all.low.y, run.box.low.y);
            all.high.y = std::max(all.high.y, run.box.high.y);
            heights += run.box.height();
        }
        met_.begin(all.grown(margin_), runs_.size(), heights);
    }

    void cut(const EdgePath& path, std::uint32_t number) {
        const auto edges = static_cast<std::uint32_t>(path.edges());
        std::uint32_t begin = 0;
        int right = 0;
        int up = 0;
        for (std::uint32_t e = 0; e < edges; ++e) {
            const Point from = path[e];
            const Point to = path[e + 1];
            const int own_right = (to.x > from.x) - (to.x < from.x);
            const int own_up = (to.y > from.y) - (to.y < from.y);
            if (own_right * right < 0 || own_up * up < 0) {
                runs_.push_back({number, begin, e, right, up, FlatBox::around(path[begin], from)});
                begin = e;
                right = 0;
                up = 0;
            }
            right = own_right != 0 ? own_right : right;
            up = own_up != 0 ? own_up : up;
        }
        runs_.push_back({number, begin, edges, right, up, FlatBox::around(path[begin], path[edges])});
    }

    bool leads_into(const Run& run, const Run& next) const noexcept {
        const EdgePath& path = paths_[run.path];
        const std::size_t end = path.closed && run.end == path.edges() ? 0 : run.end;
        return run.path == next.path && end == next.begin;
    }

    /// Whether `next`, which follows `run`, meets it nowhere but in their joint: one direction goes on, and the edges at the
    /// joint do not lie on each other along a horizontal or vertical line.
    bool leads_away(const Run& run, const Run& next) const noexcept {
        const EdgePath& path = paths_[run.path];
        const Point before = path[run.end - 1];
        const Point joint = path[next.begin];
        const Point after = path[next.begin + 1];
        const bool back = (before.y == joint.y && joint.y == after.y) || (before.x == joint.x && joint.x == after.x);
        return run.goes_on_in(next) && !back;
    }

    template <class Meet>
    void compare_runs(const Run& a, const Run& b, Meet& meet) {
        const bool apart = (leads_into(a, b) && leads_away(a, b)) || (leads_into(b, a) && leads_away(b, a));
        if (!apart) {
            compare(a, b, meet);
        }
    }

    /// Halves the longer until both are single edges. As deep as the logarithms of their lengths.
    template <class Meet>
    void compare(const Run& a, const Run& b, Meet& meet) {
        spend(1);
        const std::uint32_t a_edges = a.end - a.begin;
        const std::uint32_t b_edges = b.end - b.begin;
        if (cut_short_ || !a.box.grown(margin_).meets(b.box)) {
            return;
        }
        if (a_edges == 1 && b_edges == 1) {
            meet(paths_[a.path], std::size_t{a.begin}, paths_[b.path], std::size_t{b.begin});
        } else if (a_edges >= b_edges) {
            compare(part(a, a.begin, a.begin + a_edges / 2), b, meet);
            compare(part(a, a.begin + a_edges / 2, a.end), b, meet);
        } else {
            compare(a, part(b, b.begin, b.begin + b_edges / 2), meet);
            compare(a, part(b, b.begin + b_edges / 2, b.end), meet);
        }
    }

    Run part(const Run& run, std::uint32_t begin, std::uint32_t end) const noexcept {
        const EdgePath& path = paths_[run.path];
        return {run.path, begin, end, run.right, run.up, FlatBox::around(path[begin], path[end])};
    }

    std::vector<EdgePath> paths_;
    std::vector<Run> runs_;
    std::uint64_t edges_ = 0;
    Strips met_;
    std::int32_t margin_ = 0;
    std::uint64_t steps_left_ = 0;
    bool cut_short_ = false;
    StopCheck host_;
    std::uint32_t calls_ = 0;
};

}  // namespace lamella
