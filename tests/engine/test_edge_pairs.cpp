// Pairs of edges near one another, compared with a test of all pairs.
#include <array>
#include <map>
#include <random>
#include <utility>

#include <catch2/catch.hpp>

#include "lamella/context.hpp"
#include "rings.hpp"
#include "slicing/edges/pair_search.hpp"
#include "slicing/edges/slab_search.hpp"
#include "slicing/regions/snap_rounding.hpp"

using namespace lamella;

namespace {

struct Path {
    std::vector<Point> points;
    bool closed = true;
    std::size_t start = 0;

    EdgePath given(std::size_t number) const { return {points, number, closed, start}; }
};
using Layer = std::vector<Path>;
/// Path and edge of both, the smaller first; how often it was found.
using Pairs = std::map<std::array<std::size_t, 4>, int>;
constexpr std::uint64_t unlimited = std::uint64_t{1} << 60;

std::array<std::size_t, 4> pair_of(std::size_t a, std::size_t i, std::size_t b, std::size_t j) {
    return std::pair(a, i) < std::pair(b, j) ? std::array{a, i, b, j} : std::array{b, j, a, i};
}

Pairs found(EdgePairs& search, const Layer& layer, std::int32_t margin) {
    search.clear();
    for (std::size_t p = 0; p < layer.size(); ++p) {
        search.add(layer[p].given(p));
    }
    Pairs pairs;
    REQUIRE(search.find(margin, unlimited, [&](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        ++pairs[pair_of(a.contour, i, b.contour, j)];
    }));
    return pairs;
}

/// Of the layer in which `search` found pairs last.
Pairs found_in_slabs(SlabSearch& slabs, const EdgePairs& search) {
    Pairs pairs;
    const auto count = [&](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        ++pairs[pair_of(a.contour, i, b.contour, j)];
    };
    slabs.find(search, search.by_path(count));
    return pairs;
}

/// True if the edges from a[i] and b[j] come within `margin` of each other; may be true somewhat farther away.
bool are_near(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j, std::int32_t margin) {
    return rings::meet(a[i], a[i + 1], b[j], b[j + 1]) || is_near(a[i], b[j], b[j + 1], margin) ||
           is_near(a[i + 1], b[j], b[j + 1], margin) || is_near(b[j], a[i], a[i + 1], margin) ||
           is_near(b[j + 1], a[i], a[i + 1], margin);
}

/// Checks that pairs found in slabs have all that come near each other of those found by boxes.
void check_slabs(const Layer& layer, std::int32_t margin, const Pairs& by_boxes, const Pairs& in_slabs) {
    for (const auto& [pair, times] : by_boxes) {
        const auto [p, i, q, j] = pair;
        if (are_near(layer[p].given(p), i, layer[q].given(q), j, margin) && !in_slabs.contains(pair)) {
            FAIL("paths " << p << ' ' << q << " edges " << i << ' ' << j << " margin " << margin);
        }
    }
}

/// True if the path from edge `i` to edge `j` never turns back in x or in y.
bool is_monotone(const EdgePath& path, std::size_t i, std::size_t j) {
    FlatBox way{{0, 0}, {0, 0}};  // of its edges' vectors
    for (std::size_t e = i;; e = (e + 1) % path.edges()) {
        const Point along{path[e + 1].x - path[e].x, path[e + 1].y - path[e].y};
        way.include({along, along});
        if (e == j) {
            return (way.low.x == 0 || way.high.x == 0) && (way.low.y == 0 || way.high.y == 0);
        }
    }
}

/// True where two edges of one path with close boxes are of different runs, or meet elsewhere than in a corner between them.
bool must_be_found(const EdgePath& path, std::size_t i, std::size_t j) {
    const bool leads_on = j == i + 1 || (path.closed && i == 0 && j + 1 == path.edges());
    if (!leads_on || (path.closed && path.edges() == 2)) {
        return rings::meet(path[i], path[i + 1], path[j], path[j + 1]) ||
               !(is_monotone(path, i, j) || (path.closed && is_monotone(path, j, i)));
    }
    const auto [first, second] = j == i + 1 ? std::pair(i, j) : std::pair(j, i);
    const Point from = path[first];
    const Point joint = path[second];
    const Point to = path[second + 1];
    const std::int64_t onwards = (std::int64_t{joint.x} - from.x) * (std::int64_t{to.x} - joint.x) +
                                 (std::int64_t{joint.y} - from.y) * (std::int64_t{to.y} - joint.y);
    return rings::side(from, joint, to) == 0 && onwards < 0;
}

/// Checks `pairs` against a test of all pairs of edges.
void check(const Layer& layer, std::int32_t margin, const Pairs& pairs) {
    std::size_t expected = 0;
    for (std::size_t p = 0; p < layer.size(); ++p) {
        const EdgePath a = layer[p].given(p);
        for (std::size_t q = p; q < layer.size(); ++q) {
            const EdgePath b = layer[q].given(q);
            for (std::size_t i = 0; i < a.edges(); ++i) {
                const FlatBox grown = lamella::grown(FlatBox::around(a[i], a[i + 1]), margin);
                for (std::size_t j = p == q ? i + 1 : 0; j < b.edges(); ++j) {
                    const bool close = grown.meets(FlatBox::around(b[j], b[j + 1]));
                    const auto at = pairs.find({p, i, q, j});
                    const bool is_there = at != pairs.end();
                    const bool right = p == q ? (is_there ? close : !close || !must_be_found(a, i, j)) : is_there == close;
                    expected += is_there ? 1 : 0;
                    if (!right || (is_there && at->second != 1)) {
                        FAIL("paths " << p << ' ' << q << " edges " << i << ' ' << j << " margin " << margin);
                    }
                }
            }
        }
    }
    REQUIRE(pairs.size() == expected);
}

struct Kind {
    std::size_t paths;
    std::size_t points;
    std::int32_t range;
    std::int32_t reach;  ///< from point to point
    bool degenerate;     ///< points may be repeated
};

Path random_path(std::mt19937& random, const Kind& kind) {
    const auto below = [&](std::int64_t n) { return static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(n)); };
    Path path;
    path.closed = below(4) > 0;
    const std::size_t count = 2 + static_cast<std::size_t>(below(static_cast<std::int64_t>(kind.points)));
    Point at{below(kind.range), below(kind.range)};
    Point way{below(2) * 2 - 1, below(2) * 2 - 1};
    while (path.points.size() < count) {
        path.points.push_back(at);
        way = below(4) > 0 ? way : Point{below(3) - 1, below(3) - 1};
        const Point before = at;
        do {
            at = {before.x + way.x * below(kind.reach), before.y + way.y * below(kind.reach)};
            way = at == before ? Point{below(3) - 1, below(3) - 1} : way;
        } while (!kind.degenerate && at == before);
    }
    if (path.closed && !kind.degenerate && path.points.back() == path.points.front()) {
        path.points.back().x += kind.reach;
    }
    path.start = path.closed ? static_cast<std::size_t>(below(static_cast<std::int64_t>(count))) : 0;
    return path;
}

Layer random_layer(std::mt19937& random, const Kind& kind) {
    Layer layer(1 + random() % kind.paths);
    for (Path& path : layer) {
        path = random_path(random, kind);
    }
    return layer;
}

TEST_CASE("edge pairs: random layers agree with a test of all pairs", "[engine][pairs]") {
    std::mt19937 random(21);
    Worker worker;
    EdgePairs search(worker);
    SlabSearch slabs(worker);
    const auto check_both = [&](const Layer& layer, std::int32_t margin) {
        const Pairs pairs = found(search, layer, margin);
        check(layer, margin, pairs);
        check_slabs(layer, margin, pairs, found_in_slabs(slabs, search));
    };
    for (int round = 0; round < 6000; ++round) {
        const Kind kind{4, 20, round % 2 == 0 ? 8 : 200, round % 2 == 0 ? 3 : 20, false};
        const Layer layer = random_layer(random, kind);
        const std::int32_t margin = std::array{0, 1, 2, 37}[static_cast<std::size_t>(round) / 2 % 4];
        INFO("round " << round);
        check_both(layer, margin);
        // Repeated points make corners of several edges, of which only pairs of two paths are specified.
        Layer single;
        for (const Path& path : random_layer(random, {4, 12, 10, 3, true})) {
            for (std::size_t e = 0; e < path.given(0).edges(); ++e) {
                single.push_back({{path.given(0)[e], path.given(0)[e + 1]}, false, 0});
            }
        }
        if (round % 6 == 0) {
            check_both(single, margin);
        }
    }
}

TEST_CASE("edge pairs: layers of thousands of edges agree with a test of all pairs", "[engine][pairs]") {
    std::mt19937 random(23);
    Worker worker;
    EdgePairs search(worker);
    SlabSearch slabs(worker);
    for (int round = 0; round < 12; ++round) {
        const bool many = round % 2 == 0;
        const Kind kind{many ? std::size_t{300} : 6, many ? std::size_t{8} : 600, 1'000'000, 20'000, false};
        Layer layer;
        while (layer.size() < (many ? 250U : 4U)) {
            layer.push_back(random_path(random, kind));
        }
        if (round % 3 == 0) {  // all at one height, one beside the other
            for (Path& path : layer) {
                for (const std::int32_t height = path.points[0].y; Point & point : path.points) {
                    point.y -= height;
                }
            }
        }
        for (const std::int32_t margin : {0, 2, 10'000}) {
            INFO("round " << round);
            const Pairs pairs = found(search, layer, margin);
            check(layer, margin, pairs);
            check_slabs(layer, margin, pairs, found_in_slabs(slabs, search));
        }
    }
}

TEST_CASE("edge pairs: slabs find few pairs of edges that lie side by side or along each other", "[engine][pairs]") {
    Worker worker;
    EdgePairs search(worker);
    SlabSearch slabs(worker);
    const std::size_t steps_of_edge = 40;  // the boxes of a thousand meet each
    const auto pairs_of = [&](const Layer& layer) {
        search.clear();
        for (std::size_t p = 0; p < layer.size(); ++p) {
            search.add(layer[p].given(p));
        }
        search.cut(1);
        std::size_t pairs = 0;
        for (const auto& [pair, times] : found_in_slabs(slabs, search)) {
            pairs += static_cast<std::size_t>(times);
        }
        return pairs;
    };
    Layer nested;
    Layer fan;
    Layer bundle;  // thirty edges along each other, over many small ones
    for (std::int32_t i = 1; i <= 1000; ++i) {
        nested.push_back({{{1000 * i, 7 * i}, {-7 * i, 1000 * i}, {-1000 * i, -7 * i}, {7 * i, -1000 * i}}, true, 0});
        fan.push_back({{{10 * i, 10 * i}, {1'000'000 + i, 1000 * i}}, false, 0});
        bundle.push_back({{{1000 * i, 10'000'000}, {1000 * i + 300, 10'000'700}}, false, 0});
    }
    CHECK(pairs_of(nested) < steps_of_edge * 4 * nested.size());
    CHECK(pairs_of(fan) < steps_of_edge * fan.size());
    for (std::int32_t i = 0; i < 30; ++i) {
        bundle.push_back({{{-i, -i}, {1'000'000 + i, 1'000'000 + i}}, false, 0});
    }
    const std::size_t pairs = pairs_of(bundle);
    CHECK(pairs >= 30 * 29 / 2);
    CHECK(pairs < steps_of_edge * bundle.size());
    Layer steep;  // a unit apart along x, 5,000 along y
    for (std::int32_t i = 0; i < 30; ++i) {
        steep.push_back({{{i, 0}, {200 + i, 1'000'000}}, false, 0});
    }
    const Pairs neighbours = found(search, steep, 1);
    check_slabs(steep, 1, neighbours, found_in_slabs(slabs, search));
}

TEST_CASE("edge pairs: neighbouring runs that lead away from each other are not compared", "[engine][pairs]") {
    Layer layer(1);
    for (std::int32_t i = 0; i < 40; ++i) {  // a ring of four runs
        const std::int32_t up = std::min(i, 40 - i);
        const std::int32_t right = std::min((i + 10) % 40, 40 - (i + 10) % 40);
        layer[0].points.push_back({1000 * right, 1000 * up});
    }
    Worker worker;
    EdgePairs search(worker);
    for (const std::size_t start : {0U, 7U, 39U}) {
        layer[0].start = start;
        const Pairs pairs = found(search, layer, 0);
        CHECK(pairs.size() <= (start == 0 ? 0U : 2U));
    }
}

TEST_CASE("edge pairs: a search ends where it is told to, and at its limit", "[engine][pairs]") {
    Layer layer;
    for (std::int32_t i = 0; i < 100; ++i) {
        layer.push_back({{{0, i}, {1000, 100 - i}}, false, 0});
    }
    Worker worker;
    EdgePairs search(worker);
    const std::size_t all = found(search, layer, 0).size();
    CHECK(all == 100 * 99 / 2);
    std::size_t met = 0;
    const auto count = [&](const EdgePath&, std::size_t, const EdgePath&, std::size_t) { ++met; };
    CHECK_FALSE(search.find(0, 1000, count));
    CHECK(met > 0);
    CHECK(met < 1000);
    met = 0;
    CHECK_FALSE(search.find(0, unlimited, [&](const EdgePath&, std::size_t, const EdgePath&, std::size_t) {
        if (++met == 17) {
            search.stop();
        }
    }));
    CHECK(met == 17);
    const auto at_once = []() noexcept { return true; };
    worker.follow(at_once);
    layer.resize(4000, layer[0]);
    search.clear();
    for (std::size_t p = 0; p < layer.size(); ++p) {
        search.add(layer[p].given(p));
    }
    CHECK_THROWS_AS(search.find(0, unlimited, count), Stopped);
}

}  // namespace
