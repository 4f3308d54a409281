// Crossings of contours. A contour falls into runs that go one way in x and one way in y: such a run does not meet itself,
// and the box of any stretch of it is that of its two ends. Runs whose boxes meet are halved until single edges are left.
//
//          ____
//         /    \          four runs, and the boxes of two stretches of the lower left one
//       _/      \_        .
//      |          |       .
//       \_      _/        .
//         \____/
#include "lamella/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

#include "8_result/exact.hpp"
#include "8_result/pair.hpp"
#include "8_result/strips.hpp"
#include "base/parallel.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t steps_per_edge = 1024;

/// A contour's points one after the other, from its first to its first again if it is closed.
struct Path {
    std::span<const Point> points;
    std::uint64_t contour;
    bool closed;

    std::size_t edges() const noexcept { return points.size() < 2 ? 0 : (closed ? points.size() : points.size() - 1); }
    /// `at` may lie up to a round beyond the last.
    Point operator[](std::size_t at) const noexcept { return points[at < points.size() ? at : at - points.size()]; }
    /// Whether there is an edge behind edge `e`.
    bool goes_on(std::size_t e) const noexcept { return closed || e + 1 < edges(); }
};

/// Edges [begin, end) of a path; edge e leads from point e to point e + 1.
struct Run {
    std::uint32_t path;
    std::uint32_t begin;
    std::uint32_t end;
    int right;  ///< 1, -1, or 0 if all edges are upright
    int up;
    FlatBox box;

    /// Whether one direction goes on: if `next` comes right behind, an upright or level line lies between the two.
    bool goes_on_in(const Run& next) const noexcept { return right * next.right >= 0 || up * next.up >= 0; }
};

int sign_of(Int128 value) noexcept {
    return (value > 0) - (value < 0);
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

/// Both paths turn in `o`, from one arm to the other. Whether the arms alternate round it, none running along another.
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

/// Searches one layer after another; its memory is kept.
class LayerSearch {
public:
    explicit LayerSearch(const SliceResult& result) : result_(result) {}

    LayerCrossings run(std::size_t layer) {
        found_ = {};
        found_.layer = layer;
        cut_into_runs();
        if (runs_.empty()) {
            return found_;
        }
        std::sort(runs_.begin(), runs_.end(), [](const Run& a, const Run& b) { return a.box.low.x < b.box.low.x; });
        begin_sweep();
        for (std::uint32_t r = 0; r < runs_.size() && !found_.at_least; ++r) {
            spend(met_.visit(runs_[r].box, [&](std::uint32_t other) { compare_runs(runs_[other], runs_[r]); }));
            met_.add(runs_[r].box, r);
        }
        return found_;
    }

private:
    void spend(std::uint64_t steps) noexcept {
        found_.at_least = found_.at_least || steps > steps_left_;
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
        met_.begin(all, runs_.size(), heights);
    }

    void cut_into_runs() {
        const Layer& layer = result_.layers[found_.layer];
        std::uint64_t edges = 0;
        paths_.clear();
        runs_.clear();
        for (std::uint64_t c = layer.first_contour; c < layer.first_contour + layer.contour_count; ++c) {
            const Contour& contour = result_.contours[c];
            const Path path{result_.points_of(contour), c, contour.role != Role::open};
            edges += path.edges();
            if (path.edges() > 0) {
                cut(path, static_cast<std::uint32_t>(paths_.size()));
                paths_.push_back(path);
            }
        }
        steps_left_ = steps_per_edge * edges;
    }

    void cut(const Path& path, std::uint32_t number) {
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
        const Path& path = paths_[run.path];
        const std::size_t end = path.closed && run.end == path.edges() ? 0 : run.end;
        return run.path == next.path && end == next.begin;
    }

    void compare_runs(const Run& a, const Run& b) {
        if (!a.goes_on_in(b) || (!leads_into(a, b) && !leads_into(b, a))) {
            compare(a, b);
        }
    }

    /// Halves the longer until both are single edges. As deep as the logarithms of their lengths.
    void compare(const Run& a, const Run& b) {
        spend(1);
        const std::uint32_t a_edges = a.end - a.begin;
        const std::uint32_t b_edges = b.end - b.begin;
        if (found_.at_least || !a.box.meets(b.box)) {
            return;
        }
        if (a_edges == 1 && b_edges == 1) {
            compare_edges(paths_[a.path], a.begin, paths_[b.path], b.begin);
        } else if (a_edges >= b_edges) {
            compare(part(a, a.begin, a.begin + a_edges / 2), b);
            compare(part(a, a.begin + a_edges / 2, a.end), b);
        } else {
            compare(a, part(b, b.begin, b.begin + b_edges / 2));
            compare(a, part(b, b.begin + b_edges / 2, b.end));
        }
    }

    Run part(const Run& run, std::uint32_t begin, std::uint32_t end) const noexcept {
        const Path& path = paths_[run.path];
        return {run.path, begin, end, run.right, run.up, FlatBox::around(path[begin], path[end])};
    }

    /// A corner belongs to the edge that ends in it, so that each passage is seen in one pair of edges.
    void compare_edges(const Path& a, std::size_t i, const Path& b, std::size_t j) {
        const int b_from = side(a[i], a[i + 1], b[j]);
        const int b_to = side(a[i], a[i + 1], b[j + 1]);
        const int a_from = side(b[j], b[j + 1], a[i]);
        const int a_to = side(b[j], b[j + 1], a[i + 1]);
        if (b_from * b_to < 0 && a_from * a_to < 0) {
            note(crossing_of(a[i], a[i + 1], b[j], b[j + 1]), a, b);
        } else if (a[i + 1] == b[j + 1]) {
            if (a.goes_on(i) && b.goes_on(j) && pass_through(a[i + 1], a[i], a[i + 2], b[j], b[j + 2])) {
                note(a[i + 1], a, b);
            }
        } else if (a_to == 0 && b_from * b_to < 0) {
            passes_edge(a, i, b, j);
        } else if (b_to == 0 && a_from * a_to < 0) {
            passes_edge(b, j, a, i);
        }
    }

    /// The corner in which edge i of `a` ends lies inside edge j of `b`.
    void passes_edge(const Path& a, std::size_t i, const Path& b, std::size_t j) {
        if (a.goes_on(i) && side(b[j], b[j + 1], a[i]) * side(b[j], b[j + 1], a[i + 2]) < 0) {
            note(a[i + 1], a, b);
        }
    }

    /// Where two edges that cross do so, to the nearest unit but for the rounding of double.
    static Point crossing_of(Point a, Point b, Point c, Point d) noexcept {
        const auto from = static_cast<double>(side_of_line(c, d, a));
        const auto to = static_cast<double>(side_of_line(c, d, b));
        const double part = from / (from - to);
        return {static_cast<std::int32_t>(std::lround(a.x + part * (static_cast<double>(b.x) - a.x))),
                static_cast<std::int32_t>(std::lround(a.y + part * (static_cast<double>(b.y) - a.y)))};
    }

    void note(Point place, const Path& a, const Path& b) {
        const auto [lower, upper] = std::minmax(a.contour, b.contour);
        const std::array<std::uint64_t, 2> pair{lower, upper};
        if (found_.count++ == 0 || std::tie(place, pair) < std::tie(found_.first, found_.contours)) {
            found_.first = place;
            found_.contours = pair;
        }
    }

    const SliceResult& result_;
    std::vector<Path> paths_;
    std::vector<Run> runs_;
    Strips met_;
    std::uint64_t steps_left_ = 0;
    LayerCrossings found_;
};

Result<Crossings> find_or_throw(const SliceResult& result, int threads) {
    if (threads < 0) {
        return Error{Code::invalid_argument, "threads must not be negative"};
    }
    if (Status status = examine(result); !status) {
        return status.error();
    }
    const Parallel parallel(threads);
    struct Worker {
        LayerSearch search;
        std::vector<LayerCrossings> found;
    };
    std::vector<Worker> workers(static_cast<std::size_t>(parallel.threads()), Worker{LayerSearch(result), {}});
    parallel.run(result.layers.size(), [&](std::size_t layer, int worker) {
        Worker& own = workers[static_cast<std::size_t>(worker)];
        const LayerCrossings found = own.search.run(layer);
        if (found.count > 0 || found.at_least) {
            own.found.push_back(found);
        }
    });
    Crossings all;
    for (const Worker& own : workers) {
        all.layers.insert(all.layers.end(), own.found.begin(), own.found.end());
    }
    std::sort(all.layers.begin(), all.layers.end(),
              [](const LayerCrossings& a, const LayerCrossings& b) { return a.layer < b.layer; });
    for (const LayerCrossings& layer : all.layers) {
        all.count += layer.count;
        all.at_least = all.at_least || layer.at_least;
    }
    return all;
}

}  // namespace

Result<Crossings> find_crossings(const SliceResult& result, int threads) noexcept {
    try {
        return find_or_throw(result, threads);
    } catch (...) {                                          // bad_alloc, or threads that the system would not start
        return Error{Code::out_of_memory, "out of memory"};  // short enough to need none
    }
}

}  // namespace lamella
