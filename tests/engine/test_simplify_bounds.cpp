// What simplification compares exactly, and the steps that it takes where contours are made to need many.
#include <cstdint>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "cpu_time.hpp"
#include "engine/rounds.hpp"
#include "engine/simplify_checks.hpp"
#include "slicing/simplify/chain.hpp"

using namespace simplify_checks;

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
    const LayerContours made = region_by({ring}, simplified_by(1));
    CHECK(made.points.size() > count / 2);
    CHECK(cpu_ms() - before < 4000);
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
    std::vector<lamella::NestItem> items;
    for (const Ring& ring : rings) {
        items.push_back(lamella::closed_item(ring));
    }
    const double before = cpu_ms();
    lamella::Worker worker;
    lamella::Simplifier simplifier(worker);
    simplifier.run(items, 100);
    CHECK(items[0].count < 50'000);
    CHECK(cpu_ms() - before < 4000);
}

/// How many points are left of all.
std::size_t points_left(const Rings& rings, std::int64_t tolerance) {
    std::vector<lamella::NestItem> items;
    for (const Ring& ring : rings) {
        items.push_back(lamella::closed_item(ring));
    }
    lamella::Worker worker;
    lamella::Simplifier simplifier(worker);
    simplifier.run(items, tolerance);
    std::size_t points = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
        points += items[i].count;
        CHECK(simplifier.left_of(i).size() == items[i].count);
    }
    return points;
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
    CHECK(points_left(crossing_needles(10), 3) == 80);
    CHECK(points_left(crossing_needles(8000), 3) == 80'000);
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
    CHECK(points_left(slanting_comb(20), 2000) < 20 * 3 + 10);
    CHECK(points_left(slanting_comb(30'000), 2'000'000) == 30'000 * 6 + 3);
}
