// Simplified contours keep what RegionRules::simplify_mm promises. Distances are compared exactly, and few steps are taken
// where contours are made to need many.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "engine/rounds.hpp"
#include "engine/shapes.hpp"
#include "engine/simplify_checks.hpp"
#include "engine/slicing.hpp"
#include "slicing/simplify/chain.hpp"

using namespace simplify_checks;

TEST_CASE("a circle keeps about as many points as its tolerance needs", "[engine][simplify]") {
    const Comparison sizes = simplify({circle(1e6, 5000)}, 1000);
    const double needed = std::numbers::pi / std::acos(1 - 1000 / 1e6);  // of chords with a sagitta of the tolerance
    CHECK(static_cast<double>(sizes.points_after) >= needed);
    CHECK(static_cast<double>(sizes.points_after) <= 2 * needed);
}

TEST_CASE("rings closer than the tolerance neither meet nor change places", "[engine][simplify]") {
    std::mt19937 random(5);
    std::size_t before = 0;
    std::size_t after = 0;
    for (int turn = 0; turn < 60; ++turn) {
        Rings rings;
        const double apart = 50 + static_cast<double>(random() % 400);
        for (int i = 0; i < 6; ++i) {
            // The same wave with every seed, so that neighbours stay apart.
            std::mt19937 wave(static_cast<unsigned>(turn));
            rings.push_back(wavy_ring(wave, {3, 4}, 4000 + apart * i, 160, 900, apart / 3, i % 2 == 0));
        }
        const Comparison sizes = simplify(rings, static_cast<double>(20 + random() % 1500));
        before += sizes.points_before;
        after += sizes.points_after;
    }
    CHECK(after < before / 2);
}

TEST_CASE("crowds of small contours keep apart under a tolerance larger than they are", "[engine][simplify]") {
    std::mt19937 random(6);
    for (int turn = 0; turn < 30; ++turn) {
        Rings rings{wavy_ring(random, {0, 0}, 3000, 300, 200, 60, false)};
        for (int i = 0; i < 80; ++i) {
            const Point centre{static_cast<std::int32_t>(random() % 8000) - 4000,
                               static_cast<std::int32_t>(random() % 8000) - 4000};
            rings.push_back(wavy_ring(random, centre, 60, 12, 20, 10, i % 2 == 0));
        }
        RegionRules rules;
        rules.fill_rule = turn % 3 == 0 ? FillRule::contours : (turn % 3 == 1 ? FillRule::non_zero : FillRule::even_odd);
        simplify(rings, static_cast<double>(10 + random() % 3000), rules);
    }
}

TEST_CASE("contours that cross or touch keep their points where they do", "[engine][simplify]") {
    std::mt19937 random(7);
    int fewer = 0;
    for (int turn = 0; turn < 40; ++turn) {
        Rings rings;
        for (int i = 0; i < 5; ++i) {
            const Point centre{static_cast<std::int32_t>(random() % 40), static_cast<std::int32_t>(random() % 40)};
            rings.push_back(wavy_ring(random, centre, 60, 90, 15, turn % 2 == 0 ? 30 : 3, false));
        }
        const Comparison sizes = simplify_as_given(rings, 1 + static_cast<std::int64_t>(random() % 12));
        fewer += sizes.points_after < sizes.points_before;
    }
    CHECK(fewer > 20);
}

TEST_CASE("a hole in a bump of its outer stays within", "[engine][simplify]") {
    // The line from (4000, 0) to (6000, 0) would pass below the hole and meet nothing.
    const Ring outer = {{0, 0}, {4000, 0}, {4500, -500}, {5500, -500}, {6000, 0}, {10'000, 0}, {10'000, 9000}, {0, 9000}};
    const Ring hole = {{4900, -300}, {4950, -200}, {5050, -300}};
    CHECK(simplify({outer}, 600).points_after == 4);
    const SliceResult both = region_by({outer, hole}, simplified_by(600));
    REQUIRE(both.contours.size() == 2);
    CHECK(both.contours[1].role == Role::hole);
    simplify({outer, hole}, 600);
}

TEST_CASE("a crescent thinner than the tolerance keeps its orientation", "[engine][simplify]") {
    Ring crescent;
    for (int i = -50; i <= 50; ++i) {
        crescent.push_back({i * 100, i * i * 2});
    }
    for (int i = 49; i > -50; --i) {
        crescent.push_back({i * 100, i * i * 2 - (2500 - i * i) / 50 + 60});
    }
    for (const double tolerance : {10.0, 100.0, 1000.0, 1e5}) {
        simplify({crescent}, tolerance);
        std::reverse(crescent.begin(), crescent.end());
        simplify({crescent}, tolerance);
    }
}

TEST_CASE("a contour of two lobes keeps the sign of its area though the larger one shrinks", "[engine][simplify]") {
    // Counter-clockwise around the left lobe, clockwise around the right one, which is smaller by less than the lines cut
    // off.
    Ring lobes;
    for (int degrees = 10; degrees <= 350; ++degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        lobes.push_back({static_cast<std::int32_t>(std::lround(1000 * std::cos(angle))) - 1000,
                         static_cast<std::int32_t>(std::lround(1000 * std::sin(angle)))});
    }
    const std::size_t left = lobes.size();
    std::int32_t width = 100;
    do {
        lobes.resize(left);
        lobes.insert(lobes.end(), {{15, 174}, {width, 174}, {width, -174}, {15, -174}});
        ++width;
    } while (lamella::to_int128(lamella::closed_item(lobes).twice_area) > 1000);
    REQUIRE(lamella::to_int128(lamella::closed_item(lobes).twice_area) > 0);
    const Comparison sizes = simplify_as_given({lobes}, 10);
    CHECK(sizes.points_after < sizes.points_before);
}

TEST_CASE("contours as wide as the grid are simplified exactly", "[engine][simplify]") {
    constexpr std::int32_t far = lamella::grid_limit;
    const Ring square = {{-far, -far}, {0, -far + 1000}, {far, -far}, {far - 1000, 0},
                         {far, far},   {5, far - 1001},  {-far, far}};
    CHECK(simplify({square}, 1000).points_after == 5);
    CHECK(simplify({square}, 1001).points_after == 4);
    CHECK(simplify({square}, 999).points_after == 7);
}

TEST_CASE("layers of solids and open polylines are simplified alike on any number of threads", "[engine][simplify]") {
    for (const bool open : {false, true}) {
        shapes::Soup soup = shapes::octasphere({0, 0, 0}, 20, 6);
        soup.resize(open ? soup.size() / 9 * 7 / 10 * 9 : soup.size());
        lamella::SliceOptions options;
        options.layer_height_mm = 1.5;
        const SliceResult before = sliced(soup, options, {.threads = 1});
        options.region.simplify_mm = 0.05;
        const SliceResult after = sliced(soup, options, {.threads = 1});
        CHECK((before.info.open_contours > 0) == open);
        CHECK(after.points.size() < before.points.size() / 2);
        for (std::size_t l = 0; l < before.layers.size(); ++l) {
            compare(before[l].contours, before.points.span(), after[l].contours, after.points.span(),
                    std::floor(0.05 / before.info.grid_mm));
        }
        for (const int threads : {2, 3}) {
            CHECK(sliced(soup, options, {.threads = threads}).hash() == after.hash());
        }
    }
}

TEST_CASE("the distance of a chain is compared exactly", "[engine][simplify]") {
    std::mt19937 random(8);
    std::size_t within = 0;
    for (unsigned turn = 0; turn < rounds(20'000); ++turn) {
        const unsigned side_length = 1U << (2 + random() % 12);
        std::vector<Point> chain(2 + random() % 6);
        for (Point& p : chain) {
            p = {static_cast<std::int32_t>(random() % side_length), static_cast<std::int32_t>(random() % side_length)};
        }
        const auto tolerance = static_cast<std::int64_t>(random() % side_length);
        const std::size_t last = chain.size() - 1;
        const Point a = chain[0];
        const Point b = chain[last];
        bool expected = a != b;
        for (std::size_t i = 1; i < last && expected; ++i) {
            const Wide length2 = dot(a, b, b);
            const Wide along = dot(a, b, chain[i]);
            const Wide area = rings::cross(a, b, chain[i]);
            const Point end = along <= 0 ? a : b;
            expected = along > 0 && along < length2 ? area * area <= Wide{tolerance} * tolerance * length2
                                                    : dot(end, chain[i], chain[i]) <= Wide{tolerance} * tolerance;
        }
        if (last >= 2) {
            const auto reach = lamella::measure_chain(chain.data(), 0, last, tolerance);
            REQUIRE(reach.within == expected);
            REQUIRE((reach.furthest > 0 && reach.furthest < last));
            within += expected;
        }
    }
    CHECK(within > rounds(20'000) / 10);
}

TEST_CASE("simplifying takes no square of time where each furthest point peels off one", "[engine][simplify]") {
    constexpr int count = 300'000;
    Ring ring;
    for (int i = 0; i < count; ++i) {
        ring.push_back({i, (i % 2 == 0 ? 1 : -1) * (count - i)});
    }
    ring.push_back({count, -2 * count});
    ring.push_back({-5, -2 * count});
    const double before = cpu_ms();
    const SliceResult made = region_by({ring}, simplified_by(1));
    CHECK(made.points.size() > count / 2);
    CHECK(cpu_ms() - before < 4000);
}

/// How many points are left of each ring.
std::vector<std::size_t> points_left(const Rings& rings, std::int64_t tolerance) {
    std::vector<lamella::NestItem> items;
    for (const Ring& ring : rings) {
        items.push_back(lamella::closed_item(ring));
    }
    lamella::Worker worker;
    lamella::Simplifier simplifier(worker);
    simplifier.run(items, tolerance);
    std::vector<std::size_t> points;
    for (std::size_t i = 0; i < items.size(); ++i) {
        points.push_back(items[i].count);
        CHECK(simplifier.left_of(i).size() == items[i].count);
    }
    return points;
}

std::size_t all_points_left(const Rings& rings, std::int64_t tolerance) {
    const std::vector<std::size_t> points = points_left(rings, tolerance);
    return std::accumulate(points.begin(), points.end(), std::size_t{0});
}

/// Teeth side by side below y = 0, and between each two of them a small contour.
Rings comb(int teeth) {
    Rings rings(1);
    for (int i = 0; i < teeth; ++i) {
        rings[0].insert(rings[0].end(), {{20 * i, 0}, {20 * i + 2, -50}, {20 * i + 4, 0}});
        rings.push_back({{20 * i + 10, -30}, {20 * i + 13, -30}, {20 * i + 13, -26}, {20 * i + 11, -25}});
    }
    rings[0].insert(rings[0].end(), {{20 * teeth, 0}, {20 * teeth, 9000}, {0, 9000}});
    return rings;
}

TEST_CASE("simplifying takes no square of time where many contours lie in the box of one line", "[engine][simplify]") {
    CHECK(simplify_as_given(comb(30), 100).points_after < 250);
    const Rings rings = comb(100'000);
    const double before = cpu_ms();
    CHECK(points_left(rings, 100)[0] < 50'000);
    CHECK(cpu_ms() - before < 4000);
}

/// Needles across each other, as many one way as the other. The point in the middle of each one's tip could go.
Rings crossing_needles(int count) {
    Rings rings;
    const std::int32_t length = 100 * count;
    for (int i = 0; i < count; ++i) {
        const std::int32_t at = 100 * i + 50;
        rings.push_back({{-10, at}, {length, at}, {length - 1, at + 5}, {length, at + 10}, {-10, at + 10}});
        rings.push_back({{at, -10}, {at + 10, -10}, {at + 10, length}, {at + 5, length - 1}, {at, length}});
    }
    return rings;
}

TEST_CASE("a layer in which far more edges cross than there are points stays whole", "[engine][simplify]") {
    CHECK(all_points_left(crossing_needles(10), 3) == 80);
    CHECK(all_points_left(crossing_needles(8000), 3) == 80'000);
}

/// Slanting teeth, so that the box of each holds the small contours between all others.
Rings slanting_comb(int teeth) {
    Rings rings(1);
    const std::int32_t length = 40 * teeth;
    for (int i = 0; i < teeth; ++i) {
        const std::int32_t x = 40 * i;
        rings[0].insert(rings[0].end(), {{x, 0}, {x + length, -length}, {x + 20, 0}});
        const std::int32_t between = x + length / 2 + 20;
        rings.push_back({{between, -length / 2}, {between + 4, -length / 2}, {between + 4, -length / 2 + 2}});
    }
    rings[0].insert(rings[0].end(), {{length, 0}, {length, 9 * length}, {0, 9 * length}});
    return rings;
}

TEST_CASE("a layer in which boxes of far more edges hold a contour than there are points stays whole",
          "[engine][simplify]") {
    CHECK(all_points_left(slanting_comb(20), 2000) < 20 * 3 + 10);
    CHECK(all_points_left(slanting_comb(30'000), 2'000'000) == 30'000 * 6 + 3);
}
