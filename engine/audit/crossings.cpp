// Crossings of contours, found among the edges that come near one another.
#include "lamella/audit/crossings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "audit/pair.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/sign.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/regions/edge_pairs.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t steps_per_comparison = 64;  ///< of the edges' order: what O(m log m) allows for

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

/// Searches one layer after another; its memory is kept.
class LayerSearch {
public:
    LayerSearch(const SliceResult& result, const StopCheck& stop) : result_(result) { near_.follow(stop); }

    LayerCrossings run(std::size_t layer) {
        found_ = {};
        found_.layer = layer;
        near_.clear();
        const Layer& own = result_.layers[layer];
        for (std::uint64_t c = own.first_contour; c < own.first_contour + own.contour_count; ++c) {
            const Contour& contour = result_.contours[c];
            near_.add({result_.points_of(contour), c, contour.role != Role::open});
        }
        found_.at_least = !near_.find(
            0, most_steps(near_.edges()),
            [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) { compare_edges(a, i, b, j); });
        return found_;
    }

private:
    /// A corner belongs to the edge that ends in it, so that each passage is seen in one pair of edges.
    void compare_edges(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
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
    void passes_edge(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        if (a.goes_on(i) && side(b[j], b[j + 1], a[i]) * side(b[j], b[j + 1], a[i + 2]) < 0) {
            note(a[i + 1], a, b);
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
        const std::array<std::uint64_t, 2> pair{lower, upper};
        if (found_.count++ == 0 || std::tie(place, pair) < std::tie(found_.first, found_.contours)) {
            found_.first = place;
            found_.contours = pair;
        }
        if (found_.count == most_crossings_in_layer) {
            near_.stop();
        }
    }

    const SliceResult& result_;
    EdgePairs near_;
    LayerCrossings found_;
};

Result<Crossings> find_or_throw(const SliceResult& result, const Control& control) {
    if (Status status = examine(result); !status) {
        return status.error();
    }
    const Parallel parallel(control);
    struct Worker {
        LayerSearch search;
        std::vector<LayerCrossings> found;
    };
    std::vector<Worker> workers(static_cast<std::size_t>(parallel.threads()), Worker{LayerSearch(result, control.stop), {}});
    parallel.begin_stage(0.99);
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
    parallel.finish();
    return all;
}

}  // namespace

Result<Crossings> find_crossings(const SliceResult& result, const Control& control) noexcept {
    return guarded(control, [&] { return find_or_throw(result, control); });
}

}  // namespace lamella
