// Crossings of contours, on made and random paths, compared with a test of all pairs of edges and corners.
#include <array>
#include <random>

#include "engine/slicing.hpp"
#include "rings.hpp"

using namespace lamella;
using rings::side;
using Points = std::vector<Point>;

namespace {

using Path = audits::MadeContour;
using Layer = audits::MadeLayer;

bool is_closed(const Path& path) {
    return path.role != Role::open;
}

Path open_path(const Points& points) {
    return {points, Role::open, 0};
}

Crossings found(const SliceResult& result, int threads = 1) {
    return value_of(audits::crossings_of(result, {.threads = threads}));
}

std::uint64_t count_in(const Layer& layer) {
    return found(audits::made_result({layer})).count;
}

Path square(std::int32_t x, std::int32_t y, std::int32_t side) {
    return {{{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}}};
}

bool opposite(int a, int b) {
    return a * b < 0;
}

struct Edge {
    Point from;
    Point to;
};
struct Corner {
    Point before;
    Point at;
    Point after;
};

/// Orders directions by angle from the positive x axis.
bool comes_round_before(Point a, Point b) {
    const auto half = [](Point p) { return p.y < 0 || (p.y == 0 && p.x < 0); };
    return half(a) != half(b) ? half(b) : std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x > 0;
}

/// True where four arms of distinct directions alternate around the corner.
bool alternate(const Corner& a, const Corner& b) {
    struct Arm {
        Point to;
        int owner;
    };
    const auto arm = [](Point o, Point p, int owner) { return Arm{{p.x - o.x, p.y - o.y}, owner}; };
    std::array<Arm, 4> arms = {arm(a.at, a.before, 0), arm(a.at, a.after, 0), arm(b.at, b.before, 1), arm(b.at, b.after, 1)};
    std::sort(arms.begin(), arms.end(), [](const Arm& x, const Arm& y) { return comes_round_before(x.to, y.to); });
    for (std::size_t i = 0; i < 4; ++i) {
        const Arm& next = arms[(i + 1) % 4];
        const bool same = !comes_round_before(arms[i].to, next.to) && !comes_round_before(next.to, arms[i].to);
        if (same || arms[i].owner == next.owner) {
            return false;
        }
    }
    return true;
}

bool passes(const Corner& corner, const Edge& edge) {
    const bool inside = rings::lies_on(edge.from, edge.to, corner.at) && corner.at != edge.from && corner.at != edge.to;
    return inside && opposite(side(edge.from, edge.to, corner.before), side(edge.from, edge.to, corner.after));
}

/// Counts by testing every pair.
std::uint64_t counted(const Layer& layer) {
    std::vector<Edge> edges;
    std::vector<Corner> corners;
    for (const Path& path : layer) {
        const std::size_t n = path.points.size();
        for (std::size_t i = 0; i < n; ++i) {
            const Point next = path.points[(i + 1) % n];
            if (is_closed(path) || i + 1 < n) {
                edges.push_back({path.points[i], next});
            }
            if (is_closed(path) || (i > 0 && i + 1 < n)) {
                corners.push_back({path.points[(i + n - 1) % n], path.points[i], next});
            }
        }
    }
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Edge& a = edges[i];
            const Edge& b = edges[j];
            count += opposite(side(a.from, a.to, b.from), side(a.from, a.to, b.to)) &&
                     opposite(side(b.from, b.to, a.from), side(b.from, b.to, a.to));
        }
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (const Edge& edge : edges) {
            count += passes(corners[i], edge);
        }
        for (std::size_t j = 0; j < i; ++j) {
            count += corners[i].at == corners[j].at && alternate(corners[i], corners[j]);
        }
    }
    return count;
}

Layer random_layer(std::mt19937& random, int range) {
    const auto below = [&](int n) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(n)); };
    Layer layer(static_cast<std::size_t>(1 + below(4)));
    for (Path& path : layer) {
        path.role = below(4) > 0 ? Role::outer : Role::open;
        const int points = 2 + below(12);
        while (static_cast<int>(path.points.size()) < points) {
            const Point next{below(range), below(range)};
            if (path.points.empty() || (next != path.points.back() && next != path.points.front())) {
                path.points.push_back(next);
            }
        }
    }
    return layer;
}

/// More edges than one thread searches: squares apart, one in `every` crossed by another.
Layer wide_layer(std::int32_t every) {
    Layer layer;
    for (std::int32_t tile = 0; tile < 68'000; ++tile) {
        layer.push_back(square(100 * (tile % 300), 100 * (tile / 300), 30));
        if (tile % every == 0) {
            layer.push_back(square(100 * (tile % 300) + 20, 100 * (tile / 300) + 20, 30));
        }
    }
    return layer;
}

TEST_CASE("crossings: all threads search one wide layer, with the same answer", "[engine][crossings][threads]") {
    const SliceResult result = audits::made_result({{square(0, 0, 10), square(5, 5, 10)}, wide_layer(68)});
    const Crossings one = found(result);
    CHECK(one.count == 2 * 1000 + 2);
    CHECK_FALSE(one.at_least);
    const SliceResult too_many = audits::made_result({wide_layer(1)});
    const Crossings some = found(too_many);
    CHECK(some.at_least);
    CHECK(some.count == most_crossings_in_layer);
    for (const int threads : {2, 3}) {
        CHECK(audits::same(found(result, threads), one));
        CHECK(audits::same(found(too_many, threads), some));
    }
}

TEST_CASE("crossings: passing through a corner counts, touching it does not", "[engine][crossings]") {
    const Path line = open_path({{0, 0}, {10, 0}});
    const Path bent = open_path({{0, 0}, {5, 0}, {10, 0}});
    CHECK(count_in({line, open_path({{5, 5}, {5, 0}, {5, -5}})}) == 1);
    CHECK(count_in({line, open_path({{5, 5}, {5, 0}, {6, 5}})}) == 0);
    CHECK(count_in({bent, open_path({{5, 5}, {5, 0}, {5, -5}})}) == 1);
    CHECK(count_in({bent, open_path({{5, 5}, {5, 0}, {6, 5}})}) == 0);
    CHECK(count_in({bent, open_path({{5, 5}, {5, -5}})}) == 1);
    CHECK(count_in({line, open_path({{5, 5}, {5, 0}})}) == 0);                   // ends on the line
    CHECK(count_in({line, open_path({{0, 5}, {0, -5}})}) == 0);                  // the line ends on it
    CHECK(count_in({line, open_path({{3, 5}, {3, 0}, {7, 0}, {7, -5}})}) == 0);  // runs along the line
}

TEST_CASE("crossings: random layers agree with a test of all pairs", "[engine][crossings]") {
    std::mt19937 random(7);
    for (int round = 0; round < 20'000; ++round) {
        const Layer layer = random_layer(random, round % 2 == 0 ? 5 : 40);
        INFO("round " << round);
        REQUIRE(count_in(layer) == counted(layer));
    }
}

TEST_CASE("crossings: they are exact up to the limits of the grid", "[engine][crossings]") {
    constexpr std::int32_t far = grid_limit;
    CHECK(count_in({open_path({{-far, -far}, {far, far}}), open_path({{-far, far}, {far, -far}})}) == 1);
    CHECK(count_in({open_path({{-far, -far}, {far, far - 1}}), open_path({{-far, -far + 1}, {far, far}})}) == 0);
    CHECK(count_in({square(-far, -far, far), square(-1, -1, far)}) == 2);
    CHECK(found(SliceResult()).count == 0);
}

TEST_CASE("crossings: a search that takes too long stops and reports a lower bound", "[engine][crossings]") {
    // Slanting teeth side by side: each tooth's box overlaps all others.
    Path comb;
    constexpr std::int32_t teeth = 6000;
    for (std::int32_t i = 0; i < teeth; ++i) {
        const std::int32_t x = 4 * i;
        comb.points.insert(comb.points.end(), {{x, 0}, {1'000'000 + x, 1'000'000}, {1'000'001 + x, 1'000'000}, {x + 1, 0}});
    }
    comb.points.insert(comb.points.end(), {{4 * teeth, -10}, {-1, -10}});
    const Crossings crossings = found(audits::made_result({{comb}}));
    CHECK(crossings.at_least);
    REQUIRE(crossings.layers.size() == 1);
    CHECK(crossings.layers[0].at_least);
    CHECK(crossings.count == 0);
}

}  // namespace
