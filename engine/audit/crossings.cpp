// Crossings of contours, found among the edges that come near one another.
#include "lamella/audit.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "audit/questions.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "slicing/edges/edge_runs.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t steps_per_comparison = 64;                 ///< of the edges' order: what O(m log m) allows for
constexpr std::size_t edges_of_wide_layer = std::size_t{1} << 17;  ///< from here on all threads search one layer
constexpr std::size_t shares_of_wide_layer = 64;

std::uint64_t most_steps(std::uint64_t edges) noexcept {
    return steps_per_comparison * edges * static_cast<std::uint64_t>(std::bit_width(edges) + 1);
}

/// True if the direction from `o` to `p` lies strictly within the turn to the left from that to `a` to that to `b`.
bool in_turn(Point o, Point a, Point b, Point p) noexcept {
    const bool left_of_a = side_of(o, a, p) > 0;
    const bool right_of_b = side_of(o, b, p) < 0;
    return side_of(o, a, b) > 0 ? left_of_a && right_of_b : left_of_a || right_of_b;
}

/// True if `p` lies in the direction from `o` to `a`.
bool in_line(Point o, Point a, Point p) noexcept {
    return side_of(o, a, p) == 0 &&
           (Int128{a.x} - o.x) * (Int128{p.x} - o.x) + (Int128{a.y} - o.y) * (Int128{p.y} - o.y) > 0;
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

/// The crossings in a share of a layer.
struct Found {
    std::uint64_t count = 0;
    Point first;
    std::array<std::uint64_t, 2> contours{0, 0};
    bool cut_short = false;

    void add(const Found& other) noexcept {
        if (other.count > 0 && (count == 0 || std::tie(other.first, other.contours) < std::tie(first, contours))) {
            first = other.first;
            contours = other.contours;
        }
        count += other.count;
        cut_short = cut_short || other.cut_short;
    }
};

/// Searches one share after another; its memory is kept.
class CrossingsOfShare {
public:
    explicit CrossingsOfShare(Worker& worker) noexcept : search_(worker) {}

    /// Share `share` of `shares` of all pairs.
    Found run(const EdgeRuns& runs, std::size_t share, std::size_t shares) {
        constexpr std::uint64_t part = 8;  // of a layer's steps: all shares take at most 8 times what one thread would
        points_ = runs.points();
        found_ = {};
        const std::span<const EdgePath> paths = runs.paths();
        found_.cut_short = !search_.find(runs, share, shares, most_steps(runs.edges()) / (shares > 1 ? part : 1),
                                         [&](std::uint32_t a, std::size_t i, std::uint32_t b, std::size_t j) {
                                             compare_edges(paths[a], i, paths[b], j);
                                         });
        return found_;
    }

private:
    /// A corner belongs to the edge that ends in it, so that each passage is seen in one pair of edges.
    void compare_edges(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        const Point* const p = points_;
        const int b_from = side_of(p[i], p[i + 1], p[j]);
        const int b_to = side_of(p[i], p[i + 1], p[j + 1]);
        if (b_from * b_to > 0) {
            return;
        }
        const int a_from = side_of(p[j], p[j + 1], p[i]);
        const int a_to = side_of(p[j], p[j + 1], p[i + 1]);
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
    void passes_edge(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        const Point* const p = points_;
        if (a.goes_on(i) && side_of(p[j], p[j + 1], p[i]) * side_of(p[j], p[j + 1], p[i + 2]) < 0) {
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

    void note(Point place, const EdgePath& a, const EdgePath& b) {
        const auto [lower, upper] = std::minmax(a.contour, b.contour);
        found_.add({1, place, {lower, upper}});
        if (found_.count == most_crossings_in_layer) {
            search_.stop();
        }
    }

    PairSearch search_;
    const Point* points_ = nullptr;
    Found found_;
};

bool is_wide(const SliceResult& result, std::size_t layer) noexcept {
    std::uint64_t points = 0;
    for (const Contour& contour : result.contours_of(result.layers[layer])) {
        points += contour.point_count;
    }
    return points >= edges_of_wide_layer;
}

void add_paths(const SliceResult& result, std::size_t layer, EdgeRuns& runs) {
    const Layer& of = result.layers[layer];
    for (std::uint64_t c = of.first_contour; c < of.first_contour + of.contour_count; ++c) {
        const Contour& contour = result.contours[c];
        runs.add({{result.points.data() + contour.first_point, contour.point_count}, c, contour.role != Role::open});
    }
}

/// By all threads. Its shares do not know of one another, and so do not depend on threads.
Found search_wide(const SliceResult& result, std::size_t layer, const Parallel& parallel) {
    Worker caller(nullptr, parallel.stop());
    EdgeRuns runs(caller);
    add_paths(result, layer, runs);
    runs.cut(0, &parallel);
    std::vector<Found> shares(shares_of_wide_layer);
    parallel.run(shares.size(), [&](std::size_t share, int) {
        Worker worker(nullptr, parallel.stop());
        shares[share] = CrossingsOfShare(worker).run(runs, share, shares.size());
    });
    Found found;
    for (const Found& own : shares) {
        found.add(own);
    }
    return found;
}

/// What a thread needs to search one layer after another.
struct Searcher {
    explicit Searcher(const StopCheck& stop) noexcept : worker(nullptr, stop) {}
    Worker worker;
    CrossingsOfShare search{worker};
    EdgeRuns runs{worker};
};

}  // namespace

Crossings find_crossings(const SliceResult& result, const Parallel& parallel, double progress) {
    constexpr std::size_t runs_of_wide_layer = 6;
    std::vector<std::size_t> wide;
    for (std::size_t layer = 0; layer < result.layers.size(); ++layer) {
        if (is_wide(result, layer)) {
            wide.push_back(layer);
        }
    }
    parallel.begin_stage(progress, runs_of_wide_layer * wide.size() + 1);
    std::vector<Found> layers(result.layers.size());
    for (const std::size_t layer : wide) {
        layers[layer] = search_wide(result, layer, parallel);
    }
    std::vector<std::unique_ptr<Searcher>> searchers(static_cast<std::size_t>(parallel.threads()));
    parallel.run(layers.size(), [&](std::size_t layer, int worker) {
        std::unique_ptr<Searcher>& own = searchers[static_cast<std::size_t>(worker)];
        if (is_wide(result, layer)) {
            return;
        }
        if (!own) {
            own = std::make_unique<Searcher>(parallel.stop());
        }
        own->runs.clear();
        add_paths(result, layer, own->runs);
        own->runs.cut(0);
        layers[layer] = own->search.run(own->runs, 0, 1);
    });
    Crossings crossings;
    for (std::size_t layer = 0; layer < layers.size(); ++layer) {
        const Found& found = layers[layer];
        if (found.count > 0 || found.cut_short) {
            const std::uint64_t count = std::min(found.count, most_crossings_in_layer);
            const bool at_least = found.cut_short || count < found.count;
            crossings.count += count;
            crossings.at_least = crossings.at_least || at_least;
            crossings.layers.push_back({layer, count, at_least, found.first, found.contours});
        }
    }
    return crossings;
}

}  // namespace lamella
