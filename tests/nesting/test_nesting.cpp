// Orientation and nesting of one layer, compared with written-down answers and a brute-force oracle.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "engine/counting_memory.hpp"
#include "layer_sample.hpp"

using lamella::Nester;
using lamella::NestItem;
using lamella::Point;
using lamella::Role;
using lamella::test::add_nested;
using lamella::test::below;
using lamella::test::LayerSample;

namespace {

void nest_by_itself(std::span<NestItem> items) {
    lamella::Worker worker;
    Nester(worker).nest(items);
}

/// Nests `sample` and compares every output with the oracle's.
void check_against_oracle(const LayerSample& sample) {
    std::vector<NestItem> items = sample.items();
    nest_by_itself(items);
    REQUIRE(lamella::test::first_difference(items, sample.expected()) == -1);
}

/// The outputs of a layer whose contours are passed in `order`, with indices of the original order.
std::vector<NestItem> nest_permuted(const LayerSample& sample, const std::vector<std::size_t>& order, Nester& nester) {
    const std::vector<NestItem> plain = sample.items();
    std::vector<NestItem> shuffled;
    for (const std::size_t i : order) {
        shuffled.push_back(plain[i]);
    }
    nester.nest(shuffled);
    std::vector<NestItem> back(plain.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        back[order[i]] = shuffled[i];
        if (shuffled[i].parent >= 0) {
            back[order[i]].parent = static_cast<std::int32_t>(order[static_cast<std::size_t>(shuffled[i].parent)]);
        }
    }
    return back;
}

}  // namespace

TEST_CASE("the roles and parents of a few contours are known", "[nesting]") {
    struct Given {
        std::vector<Point> points;
        const char* expected;  ///< role, orientation, parent; whether it is overruled and reversed
        bool closed = true;
    };
    const auto box = [](std::int32_t low, std::int32_t high, bool clockwise = false) {
        return clockwise ? std::vector<Point>{{low, low}, {low, high}, {high, high}, {high, low}}
                         : std::vector<Point>{{low, low}, {high, low}, {high, high}, {low, high}};
    };
    const std::vector<Given> layers[] = {
        {},
        {{box(0, 10), "outer + in -1"}},
        // The parent of a hole is the smallest contour around it.
        {{box(30, 40, true), "hole - in 2"},
         {box(0, 100), "outer + in -1"},
         {box(20, 50), "outer + in 3"},
         {box(10, 90, true), "hole - in 1"}},
        // An inverted shell.
        {{box(0, 100, true), "outer - in -1 overruled"},
         {box(10, 90), "hole + in 0 overruled"},
         {box(200, 300), "outer + in -1"}},
        // Shells of equal orientation nest as they are: windings from outside in are 1, 2, 1, 0, and then -1.
        {{box(0, 100), "outer + in -1"},
         {box(10, 90), "outer + in 0"},
         {box(20, 80, true), "hole - in 1"},
         {box(30, 70, true), "hole - in 2"},
         {box(40, 60, true), "outer - in 3 overruled"}},
        // Open and flat contours have no parent and no children.
        {{box(0, 100), "outer + in -1"},
         {{{10, 10}, {50, 50}}, "flat 0 in -1"},
         {{{20, 10}, {80, 10}, {80, 90}}, "open 0 in -1", false},
         {box(40, 60, true), "hole - in 0"}},
        // A start on a boundary is not inside.
        {{box(0, 100), "outer + in -1"},
         {{{0, 20}, {0, 40}, {30, 40}, {30, 20}}, "outer - in -1 overruled"},  // on the left edge
         {{{10, 0}, {60, 10}, {10, 20}}, "outer + in -1"},                     // on the bottom edge
         {{{0, 0}, {90, 10}, {10, 90}}, "outer + in -1"},                      // at the corner
         {{{40, 40}, {50, 30}, {60, 40}, {50, 50}}, "outer + in 3"},           // on an edge of the contour before it
         {{{40, 40}, {50, 50}, {60, 40}, {50, 30}}, "hole - in 3"},            // the same, reversed: neither is inside
         {{{45, 35}, {52, 35}, {50, 40}}, "outer + in 3"},                     // on an edge of the last two
         {{{50, 50}, {60, 60}, {40, 60}}, "outer + in 0"}},                    // on their corner and an edge of contour 3
    };
    lamella::Worker worker;
    Nester nester(worker);
    for (const std::vector<Given>& layer : layers) {
        LayerSample sample;
        for (const Given& given : layer) {
            sample.add(given.points, given.closed);
        }
        std::vector<NestItem> items = sample.items();
        for (NestItem& item : items) {
            item.flags = lamella::orientation_mixed;  // is kept
        }
        nester.nest(items);
        for (std::size_t i = 0; i < items.size(); ++i) {
            const NestItem& item = items[i];
            const char* const roles[] = {"outer ", "hole ", "flat ", "open "};
            const bool overruled = (item.flags & lamella::orientation_overruled) != 0;
            CHECK(roles[static_cast<std::size_t>(item.role)] + std::string(1, "-0+"[item.orientation + 1]) + " in " +
                      std::to_string(item.parent) + (overruled ? " overruled" : "") ==
                  layer[i].expected);
            CHECK(item.reverse == overruled);
            CHECK((item.flags & lamella::orientation_mixed) != 0);
        }
        check_against_oracle(sample);
    }
}

TEST_CASE("nesting is exact up to the limits of the grid", "[nesting]") {
    constexpr std::int32_t far = lamella::grid_limit;
    LayerSample sample;
    sample.add({{-far, -far}, {far, far - 1}, {far, far}}, true);
    sample.add({{0, 0}, {2, 1}, {1, 1}}, true);  // these start on or beside the long edges
    sample.add({{-1, -1}, {2, 1}, {1, 1}}, true);
    sample.add({{far - 2, far - 2}, {far - 1, far - 2}, {far - 1, far - 1}}, true);
    sample.add_box({-far, -far}, {far, far}, true);
    check_against_oracle(sample);
}

TEST_CASE("random layers agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(1U, 2U, 3U, 4U));
    for (int round = 0; round < 1500; ++round) {
        CAPTURE(round);
        check_against_oracle(lamella::test::random_layer(random));
    }
}

TEST_CASE("layers of many contours agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(11U, 12U, 13U));
    for (int round = 0; round < 20; ++round) {
        LayerSample sample;
        const int size = 100 << below(random, 12);
        add_nested(sample, random, {-size, -size}, {size, size}, 5);
        sample.drop_repeated();
        CAPTURE(round, size, sample.size());
        check_against_oracle(sample);
    }
    check_against_oracle(lamella::test::concentric_rings(1500, 8));
    check_against_oracle(lamella::test::side_by_side(1500, 8));
}

TEST_CASE("many contours that cross agree with the oracle", "[nesting]") {
    std::mt19937 random(GENERATE(21U, 22U));
    const bool wide = GENERATE(false, true);  // boxes that overlap most others are looked up in a tree
    LayerSample sample;
    for (int i = 0; i < 1000; ++i) {
        const Point low{below(random, 300), below(random, 300)};
        sample.add_box(low, {low.x + (wide ? 500 : 1) + below(random, 40), low.y + 1 + below(random, 60)},
                       below(random, 2) == 0);
    }
    sample.drop_repeated();
    check_against_oracle(sample);
}

TEST_CASE("areas beyond 64 bits are compared exactly", "[nesting]") {
    constexpr std::int32_t far = lamella::grid_limit;
    const auto turns = [](std::int32_t reach, int count) {
        std::vector<Point> points;
        for (int i = 0; i < count; ++i) {
            points.insert(points.end(), {{-reach, -reach}, {reach, -reach}, {reach, reach}, {-reach, reach}});
        }
        return points;
    };
    LayerSample sample;
    sample.add(turns(far, 5), true);
    sample.add(turns(far - 1, 3), true);
    sample.add(turns(far - 2, 4), true);  // larger in area than the contour around it
    sample.add_box({0, 0}, {1, 1}, true);
    std::vector<NestItem> items = sample.items();
    nest_by_itself(items);
    CHECK(items[3].parent == 1);
    CHECK(items[2].parent == 1);
    CHECK(items[1].parent == 0);
    check_against_oracle(sample);
}

TEST_CASE("a long contour with many contours inside agrees with the oracle", "[nesting]") {
    std::mt19937 random(5);
    LayerSample sample;
    const int teeth = GENERATE(130, 600, 2500);
    std::vector<Point> comb;  // back and forth, with a level line at every tip
    for (int i = 0; i < teeth; ++i) {
        comb.insert(comb.end(), {{10 * i, 1000}, {10 * i + 5, 1000}, {10 * i + 5, 100 + below(random, 500)}});
        comb.push_back({10 * i + 9, comb.back().y});
    }
    comb.insert(comb.end(), {{10 * teeth, 0}, {0, 0}});
    sample.add(std::move(comb), true, static_cast<std::uint32_t>(random()));
    for (int i = 0; i < 60; ++i) {
        const Point low{below(random, 10 * teeth), below(random, 1000)};
        sample.add_box(low, {low.x + 2, low.y + 2}, true);
    }
    check_against_oracle(sample);
}

TEST_CASE("scratch memory is reused from layer to layer", "[nesting]") {
    std::mt19937 random(3);
    LayerSample nested;
    add_nested(nested, random, {-1000, -1000}, {1000, 1000}, 4);
    std::vector<NestItem> many = nested.items();
    const LayerSample concentric = lamella::test::concentric_rings(40, 500);
    std::vector<NestItem> rings = concentric.items();
    CountingMemory counter;
    lamella::Worker worker(&counter);
    Nester nester(worker);
    nester.nest(many);
    nester.nest(rings);
    const std::uint64_t first = counter.asked();
    REQUIRE(first > 0);
    nester.nest(rings);
    nester.nest(many);
    CHECK(counter.asked() == first);
}

TEST_CASE("nesting does not depend on the order of contours or on earlier layers", "[nesting]") {
    std::mt19937 random(7);
    lamella::Worker worker;
    Nester nester(worker);
    for (int round = 0; round < 300; ++round) {
        LayerSample sample = lamella::test::random_layer(random);
        sample.drop_repeated();  // only their index distinguishes equal contours
        std::vector<std::size_t> order(sample.size());
        for (std::size_t i = 0; i < order.size(); ++i) {
            order[i] = i;
        }
        std::shuffle(order.begin(), order.end(), random);
        CAPTURE(round);
        REQUIRE(lamella::test::first_difference(nest_permuted(sample, order, nester), sample.expected()) == -1);
    }
}
