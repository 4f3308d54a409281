// Crossings of contours, found among the edges that come near one another.
#include "lamella/audit/crossings.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>
#include <tuple>
#include <utility>
#include <vector>

#include "audit/edge_runs.hpp"
#include "audit/pair.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sign.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t steps_per_comparison = 64;                 ///< of the edges' order: what O(m log m) allows for
constexpr std::size_t edges_of_wide_layer = std::size_t{1} << 17;  ///< from here on all threads search one layer
constexpr std::size_t shares_of_wide_layer = 64;

std::uint64_t most_steps(std::uint64_t edges) noexcept {
    return steps_per_comparison * edges * static_cast<std::uint64_t>(std::bit_width(edges) + 1);
}

int side(Point from, Point to, Point p) noexcept {
    return sign_of(side_of_line(from, to, p));
}

/// Whether the direction from `o` to `p` lies strictly within the turn to the left from that to `a` to that to `b`.
bool in_turn(Point o, Point a, Point b, Point p) noexcept {
    const bool left_of_a = side(o, a, p) > 0;
    const bool right_of_b = side(o, b, p) < 0;
    return side(o, a, b) > 0 ? left_of_a && right_of_b : left_of_a || right_of_b;
}

/// Whether `p` lies in the direction from `o` to `a`.
bool in_line(Point o, Point a, Point p) noexcept {
    return side(o, a, p) == 0 && (Int128{a.x} - o.x) * (Int128{p.x} - o.x) + (Int128{a.y} - o.y) * (Int128{p.y} - o.y) > 0;
}

/// Two paths pass through `o`: a to b and c to d. Whether they cross there: the four arms alternate around `o`, and none
/// runs along another.
bool pass_through(Point o, Point a, Point b, Point c, Point d) noexcept {
    if (in_line(o, a, b)) {
        return false;  // a spike has no sides
    }
    for (const Point p : {c, d}) {
        if (in_line(o, a, p) || in_line(o, b, p)) {
            return false;
        }
    }
    return in_turn(o, a, b, c) != in_turn(o, a, b, d);
}

/// How far a search may go.
struct Limits {
    std::uint64_t steps = 0;
    std::uint64_t crossings = most_crossings_in_layer;
};

/// What some strips of a layer hold.
struct Found {
    std::uint64_t count = 0;
    Point first;
    std::array<std::uint64_t, 2> contours{0, 0};
    std::uint64_t steps = 0;
    bool cut_short = false;

    void add(const Found& other) noexcept {
        if (other.count > 0 && (count == 0 || std::tie(other.first, other.contours) < std::tie(first, contours))) {
            first = other.first;
            contours = other.contours;
        }
        count += other.count;
        steps += other.steps;
        cut_short = cut_short || other.cut_short;
    }
};

/// Searches one share after another; its memory is kept.
class StripSearch {
public:
    explicit StripSearch(const StopCheck& stop) noexcept : host_(stop), kernels_(best_of(run_kernel_forms())) {}

    /// Share `share` of `shares` of all pairs.
    Found run(const EdgeRuns& runs, std::size_t share, std::size_t shares, Limits limits) {
        runs_ = &runs;
        points_ = runs.points();
        limits_ = limits;
        found_ = {};
        const std::size_t all = runs.runs().size();
        for (std::size_t r = all * share / shares; r < all * (share + 1) / shares && !found_.cut_short; ++r) {
            if (r + 1 < all && runs.runs()[r].box.meets(runs.runs()[r + 1].box)) {
                compare_in_order(static_cast<std::uint32_t>(r), static_cast<std::uint32_t>(r + 1));
            }
        }
        const std::size_t last = runs.first_strip_of(share + 1, shares);
        for (std::size_t strip = runs.first_strip_of(share, shares); strip < last && !found_.cut_short; ++strip) {
            search(strip);
        }
        return found_;
    }

private:
    /// Part of a run.
    struct Stretch {
        FlatBox box;
        std::size_t begin;
        std::size_t end;
    };

    void spend(std::uint64_t steps) {
        constexpr std::uint64_t steps_between_stops = std::uint64_t{1} << 16;
        const std::uint64_t before = found_.steps;
        found_.steps += steps;
        if ((before ^ found_.steps) >= steps_between_stops && host_.stop_requested()) {
            throw Stopped();
        }
        found_.cut_short = found_.cut_short || found_.steps > limits_.steps;
    }

    void search(std::size_t strip) {
        const auto [begin, end] = runs_->entries_of(strip);
        meeting_.resize(std::max(meeting_.size(), end - begin));
        const BoxArrays boxes = runs_->boxes();
        const std::int32_t left = runs_->left_of(strip);  // what meets further left is found there
        for (std::size_t i = begin; i < end && !found_.cut_short; ++i) {
            const BoxesMet meeting = kernels_.find_meeting(boxes, i, end, left, meeting_.data());
            spend(meeting.beside + 1);
            for (std::size_t m = 0; m < meeting.found; ++m) {
                compare_in_order(boxes.run[i], boxes.run[meeting_[m]]);
            }
        }
    }

    /// The rounded place of a crossing depends on which comes first.
    void compare_in_order(std::uint32_t i, std::uint32_t j) {
        const EdgeRun& a = runs_->runs()[i];
        const EdgeRun& b = runs_->runs()[j];
        const bool in_order = std::tie(a.box.low.x, i) < std::tie(b.box.low.x, j);
        compare_runs(in_order ? a : b, in_order ? b : a);
    }

    bool leads_into(const EdgeRun& run, const EdgeRun& next) const noexcept {
        if (run.path != next.path) {
            return false;
        }
        const LayerPath& path = runs_->path_of(run);
        return run.end == next.begin || (path.closed && run.end == path.end && next.begin == path.begin);
    }

    /// Whether `next`, which follows `run`, meets it nowhere but in their joint: one direction goes on, and the edges at the
    /// joint do not lie on each other along a horizontal or vertical line.
    bool leads_away(const EdgeRun& run, const EdgeRun& next) const noexcept {
        const Point before = points_[run.end - 1];
        const Point joint = points_[run.end];
        const Point after = points_[next.begin + 1];
        const bool back = (before.y == joint.y && joint.y == after.y) || (before.x == joint.x && joint.x == after.x);
        return goes_on(run, next) && !back;
    }

    /// Whether one direction goes on from run to run.
    bool goes_on(const EdgeRun& run, const EdgeRun& next) const noexcept {
        const auto way = [&](const EdgeRun& r, std::int32_t Point::*axis) {
            return sign_of(std::int64_t{points_[r.end].*axis} - points_[r.begin].*axis);
        };
        return way(run, &Point::x) * way(next, &Point::x) >= 0 || way(run, &Point::y) * way(next, &Point::y) >= 0;
    }

    void compare_runs(const EdgeRun& a, const EdgeRun& b) {
        const bool apart = (leads_into(a, b) && leads_away(a, b)) || (leads_into(b, a) && leads_away(b, a));
        if (!apart) {
            compare({a.box, a.begin, a.end}, {b.box, b.begin, b.end}, runs_->path_of(a), runs_->path_of(b));
        }
    }

    /// Halves the longer until both are single edges. As deep as the logarithms of their lengths.
    void compare(const Stretch& a, const Stretch& b, const LayerPath& a_path, const LayerPath& b_path) {
        spend(1);
        if (found_.cut_short || !a.box.meets(b.box)) {
            return;
        }
        const std::size_t a_edges = a.end - a.begin;
        const std::size_t b_edges = b.end - b.begin;
        if (a_edges == 1 && b_edges == 1) {
            compare_edges(a_path, a.begin, b_path, b.begin);
        } else if (a_edges >= b_edges) {
            compare(part(a.begin, a.begin + a_edges / 2), b, a_path, b_path);
            compare(part(a.begin + a_edges / 2, a.end), b, a_path, b_path);
        } else {
            compare(a, part(b.begin, b.begin + b_edges / 2), a_path, b_path);
            compare(a, part(b.begin + b_edges / 2, b.end), a_path, b_path);
        }
    }

    Stretch part(std::size_t begin, std::size_t end) const noexcept {
        return {FlatBox::around(points_[begin], points_[end]), begin, end};
    }

    /// A corner belongs to the edge that ends in it, so that each passage is seen in one pair of edges.
    void compare_edges(const LayerPath& a, std::size_t i, const LayerPath& b, std::size_t j) {
        const Point* const p = points_;
        const int b_from = side(p[i], p[i + 1], p[j]);
        const int b_to = side(p[i], p[i + 1], p[j + 1]);
        if (b_from * b_to > 0) {
            return;
        }
        const int a_from = side(p[j], p[j + 1], p[i]);
        const int a_to = side(p[j], p[j + 1], p[i + 1]);
        if (b_from * b_to < 0 && a_from * a_to < 0) {
            note(crossing_of(p[i], p[i + 1], p[j], p[j + 1]), a, b);
        } else if (p[i + 1] == p[j + 1]) {
            if (a.goes_on(i) && b.goes_on(j) && pass_through(p[i + 1], p[i], p[i + 2], p[j], p[j + 2])) {
                note(p[i + 1], a, b);
            }
        } else if (a_to == 0 && b_from * b_to < 0) {
            passes_edge(a, i, b, j);
        } else if (b_to == 0 && a_from * a_to < 0) {
            passes_edge(b, j, a, i);
        }
    }

    /// The corner in which edge i of `a` ends lies inside edge j of `b`.
    void passes_edge(const LayerPath& a, std::size_t i, const LayerPath& b, std::size_t j) {
        const Point* const p = points_;
        if (a.goes_on(i) && side(p[j], p[j + 1], p[i]) * side(p[j], p[j + 1], p[i + 2]) < 0) {
            note(p[i + 1], a, b);
        }
    }

    /// The crossing of two edges that cross, to the nearest unit but for the rounding of double.
    static Point crossing_of(Point a, Point b, Point c, Point d) noexcept {
        const auto from = static_cast<double>(side_of_line(c, d, a));
        const auto to = static_cast<double>(side_of_line(c, d, b));
        const double part = from / (from - to);
        return {static_cast<std::int32_t>(std::lround(a.x + part * (static_cast<double>(b.x) - a.x))),
                static_cast<std::int32_t>(std::lround(a.y + part * (static_cast<double>(b.y) - a.y)))};
    }

    void note(Point place, const LayerPath& a, const LayerPath& b) {
        const auto [lower, upper] = std::minmax(a.contour, b.contour);
        found_.add({1, place, {lower, upper}});
        found_.cut_short = found_.cut_short || found_.count == limits_.crossings;
    }

    StopCheck host_;
    const RunKernels& kernels_;
    const EdgeRuns* runs_ = nullptr;
    const Point* points_ = nullptr;
    Limits limits_;
    Found found_;
    std::vector<std::uint32_t> meeting_;
};

/// Shares layers out to threads, and of a wide layer the strips.
class CrossingSearch {
public:
    CrossingSearch(const SliceResult& result, const Control& control, const Parallel& parallel)
        : result_(result), control_(control), parallel_(parallel) {}

    Crossings run() {
        std::vector<std::size_t> wide;
        for (std::size_t layer = 0; layer < result_.layers.size(); ++layer) {
            if (is_wide(result_.layers[layer])) {
                wide.push_back(layer);
            }
        }
        constexpr std::size_t runs_of_wide_layer = 6;
        parallel_.begin_stage(0.99, runs_of_wide_layer * wide.size() + 1);
        for (const std::size_t layer : wide) {
            search_wide(layer);
        }
        search_others();
        return sum();
    }

private:
    bool is_wide(const Layer& layer) const noexcept {
        std::uint64_t points = 0;
        for (const Contour& contour : result_.contours_of(layer)) {
            points += contour.point_count;
        }
        return points >= edges_of_wide_layer;
    }

    void search_others() {
        struct Worker {
            StripSearch search;
            Parallel alone;
            EdgeRuns runs;
            std::vector<LayerCrossings> found;
            explicit Worker(const Control& control) : search(control.stop), alone({.threads = 1, .stop = control.stop}) {}
        };
        std::vector<std::unique_ptr<Worker>> workers(static_cast<std::size_t>(parallel_.threads()));
        parallel_.run(result_.layers.size(), [&](std::size_t layer, int worker) {
            std::unique_ptr<Worker>& own = workers[static_cast<std::size_t>(worker)];
            if (is_wide(result_.layers[layer])) {
                return;
            }
            if (!own) {
                own = std::make_unique<Worker>(control_);
            }
            own->runs.assign(result_, result_.layers[layer], own->alone);
            const Found found = own->search.run(own->runs, 0, 1, {.steps = most_steps(own->runs.edges())});
            keep(layer, found, own->found);
        });
        for (const std::unique_ptr<Worker>& own : workers) {
            if (own) {
                all_.insert(all_.end(), own->found.begin(), own->found.end());
            }
        }
    }

    static void keep(std::size_t layer, const Found& found, std::vector<LayerCrossings>& layers) {
        if (found.count > 0 || found.cut_short) {
            layers.push_back({layer, found.count, found.cut_short, found.first, found.contours});
        }
    }

    /// As if one thread searched strip after strip. A share is searched as if it came first; where all before it leave less
    /// than it took, it is searched again with what they leave.
    void search_wide(std::size_t layer) {
        EdgeRuns runs;
        runs.assign(result_, result_.layers[layer], parallel_);
        const Limits whole{.steps = most_steps(runs.edges())};
        std::vector<Found> shares(shares_of_wide_layer);
        std::atomic<std::size_t> last{shares_of_wide_layer};  // the first share known to be cut short
        parallel_.run(shares.size(), [&](std::size_t share, int) {
            if (share > last.load(std::memory_order_relaxed)) {
                return;
            }
            constexpr std::uint64_t part = 8;  // so that all together take at most so many times what one thread would
            StripSearch search(control_.stop);
            shares[share] = search.run(runs, share, shares.size(), {whole.steps / part, whole.crossings});
            if (shares[share].count == whole.crossings) {
                last.store(share, std::memory_order_relaxed);
            }
        });
        Found found;
        StripSearch search(control_.stop);
        for (std::size_t share = 0; share < shares.size() && !found.cut_short; ++share) {
            const Limits left{whole.steps - found.steps, whole.crossings - found.count};
            const Found& own = shares[share];
            const bool fits = !own.cut_short && own.steps <= left.steps && own.count < left.crossings;
            found.add(fits ? own : search.run(runs, share, shares.size(), left));
        }
        keep(layer, found, all_);
    }

    Crossings sum() {
        std::sort(all_.begin(), all_.end(),
                  [](const LayerCrossings& a, const LayerCrossings& b) { return a.layer < b.layer; });
        Crossings crossings;
        for (const LayerCrossings& layer : all_) {
            crossings.count += layer.count;
            crossings.at_least = crossings.at_least || layer.at_least;
        }
        crossings.layers = std::move(all_);
        return crossings;
    }

    const SliceResult& result_;
    const Control& control_;
    const Parallel& parallel_;
    std::vector<LayerCrossings> all_;
};

Result<Crossings> find_or_throw(const SliceResult& result, const Control& control) {
    if (Status status = examine(result); !status) {
        return status.error();
    }
    const Parallel parallel(control);
    Crossings all = CrossingSearch(result, control, parallel).run();
    parallel.finish();
    return all;
}

}  // namespace

Result<Crossings> find_crossings(const SliceResult& result, const Control& control) noexcept {
    return guarded(control, [&] { return find_or_throw(result, control); });
}

}  // namespace lamella
