// Laws of sets that combinations of layers obey, to the unit where every crossing lies on the grid; and answers as input of
// all else that takes a result.
#include <algorithm>
#include <memory>
#include <random>

#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/overlay.hpp"
#include "regions/region.hpp"

using namespace lamella;
using regions::Polygon;
using regions::Polygons;

namespace {

SliceResult combined(std::span<const LayerSet> sets, const Rule& rule, const RegionRules& after = {}) {
    SliceResult result;
    (void)value_of(Overlay().combine(result, sets, rule, after));
    require_ok(audits::structure_of(result));
    return result;
}
SliceResult combined(const SliceResult& a, const SliceResult& b, const Rule& rule) {
    const LayerSet sets[] = {{.layers = a}, {.layers = b}};
    return combined(sets, rule);
}

Int128 twice_area_of(const SliceResult& result) {
    return regions::twice_area(regions::region_in(result));
}

/// Of polygons whose edges cross each other on the grid only: on the lattice 0 to 3, of which a cell is divisible by every
/// determinant of two directions.
SliceResult region_on_lattice(std::mt19937& random) {
    constexpr std::int32_t cell = 360'360;
    Polygons all(1 + random() % 3);
    for (Polygon& polygon : all) {
        polygon.resize(3 + random() % 6);
        for (Point& p : polygon) {
            p = {polygons::below(random, 4) * cell, polygons::below(random, 4) * cell};
        }
    }
    return regions::region_of(all, random() % 2 == 0 ? FillRule::even_odd : FillRule::non_zero);
}

bool same_region(const SliceResult& a, const SliceResult& b) {
    return regions::region_in(a) == regions::region_in(b);
}

}  // namespace

TEST_CASE("areas of union and intersection add up to those of the sets, and sets obey their laws", "[regions][overlay]") {
    std::mt19937 random(5);
    for (int round = 0; round < 300; ++round) {
        const SliceResult a = region_on_lattice(random);
        const SliceResult b = region_on_lattice(random);
        const SliceResult both = combined(a, b, unite);
        const SliceResult common = combined(a, b, intersect(2));
        const SliceResult rest = combined(a, b, subtract);
        const SliceResult other_rest = combined(b, a, subtract);
        REQUIRE(twice_area_of(a) + twice_area_of(b) == twice_area_of(both) + twice_area_of(common));
        REQUIRE(twice_area_of(rest) + twice_area_of(common) == twice_area_of(a));
        REQUIRE(both.hash() == combined(b, a, unite).hash());
        REQUIRE(common.hash() == combined(b, a, intersect(2)).hash());
        const SliceResult either = combined(a, b, exclusive);
        REQUIRE(either.hash() == combined(b, a, exclusive).hash());
        REQUIRE(same_region(combined(rest, common, unite), a));
        REQUIRE(same_region(combined(rest, other_rest, unite), either));
        REQUIRE(same_region(combined(both, common, subtract), either));
        REQUIRE(same_region(combined(a, both, intersect(2)), a));
        REQUIRE(combined(a, a, subtract).contours.empty());
        REQUIRE(combined(rest, b, intersect(2)).contours.empty());
    }
}

TEST_CASE("squares in one another, turned, obey the laws where all their boxes meet", "[regions][overlay]") {
    constexpr std::int32_t count = 400;
    const auto squares_around = [](Point centre) {
        Polygons all;
        for (std::int32_t i = 1; i <= count; ++i) {
            const std::int32_t reach = 10 * i;
            Polygon& square = all.emplace_back(Polygon{{centre.x + reach, centre.y},
                                                       {centre.x, centre.y + reach},
                                                       {centre.x - reach, centre.y},
                                                       {centre.x, centre.y - reach}});
            if (i % 2 == 1) {
                std::reverse(square.begin(), square.end());
            }
        }
        return regions::region_of(all, FillRule::non_zero);
    };
    const SliceResult a = squares_around({0, 0});
    const SliceResult b = squares_around({4, 2});
    CHECK(a.contours.size() == count);
    const SliceResult both = combined(a, b, unite);
    CHECK(twice_area_of(a) == 2 * std::int64_t{10} * 10 * count * (count + 1));
    CHECK(twice_area_of(a) + twice_area_of(b) == twice_area_of(both) + twice_area_of(combined(a, b, intersect(2))));
    CHECK(both.hash() == combined(b, a, unite).hash());
}

TEST_CASE("answers are input of every operation and every question", "[regions][overlay]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 10}, 10, 4);
    const shapes::Soup bar = shapes::box({-20, -2, 4}, {20, 3, 16});
    const Part parts[] = {{view_of(ball)}, {view_of(bar)}};
    const SliceResult sliced_parts = sliced(parts, {.layer_height_mm = 1, .region = {.fill_rule = FillRule::non_zero}});
    const LayerSet sets[] = {{.layers = sliced_parts, .part = 0}, {.layers = sliced_parts, .part = 1}};
    const std::uint32_t labels[] = {0, 1, 2, 3};
    const SliceResult by_label = combined(sets, {.labels = labels});
    const SliceResult united = combined(sets, unite);
    const RegionRules rules[] = {{.closing_mm = 0.5}, {.offset_mm = -0.5}, {.largest_only = true}, {.simplify_mm = 0.25}};
    for (const SliceResult* const answer : {&by_label, &united}) {
        const auto crossings = audits::crossings_of(*answer);
        REQUIRE(crossings.ok());
        CHECK(crossings->count == 0);
        const LayerSet again[] = {{.layers = *answer}, {.layers = *answer, .from = 1, .to = 2, .grow_mm = 0.25}};
        CHECK(combined({again, 1}, unite).size() == answer->size());
        CHECK_FALSE(combined(again, subtract).contours.empty());
        for (const RegionRules& after : rules) {
            CHECK_FALSE(combined({again, 1}, unite, after).contours.empty());
        }
        for (const LayerView layer : *answer) {
            const Polygons rings = regions::rings_of(layer);
            const SliceResult alone = value_of(regions::region(rings, {.fill_rule = FillRule::positive}));
            CHECK(alone[0].area_mm2() == Approx(layer.area_mm2()).margin(1e-4));
        }
    }
    // What the parts of an answer hold is what they held.
    for (std::uint32_t part = 0; part < 3; ++part) {
        const LayerSet own[] = {{.layers = by_label, .part = part}};
        const std::uint32_t own_labels[] = {0, part == 0 ? 1U : 0, part == 1 ? 1U : 0, part == 2 ? 1U : 0};
        CHECK(same_region(combined(own, unite), combined(sets, {.labels = own_labels})));
    }
}

TEST_CASE("the answer's box holds all sets, so that a host's integers that are too small are refused",
          "[regions][overlay]") {
    const SliceResult low = sliced(shapes::box({0, 0, 0}, {4, 4, 4}), uniform(1));
    const SliceResult high = sliced(shapes::box({2, 2, 0}, {9, 6, 4}), uniform(1));
    CHECK(combined(low, low, unite).info.box == low.info.box);
    CHECK(combined(low, high, unite).info.box == Box{{0, 0, 0}, {9, 6, 4}});
    const LayerSet grown[] = {{.layers = low, .grow_mm = 1}};
    CHECK(combined(grown, unite).info.box.max_mm[0] >= 5);
    CHECK(combined(grown, unite).info.box.max_mm[2] == 4);
    const Point square[] = {{8, 8}, {1 << 29, 8}, {1 << 29, 1 << 29}, {8, 1 << 29}};
    const std::span<const Point> contours[] = {square};
    const ContourSet given{.contours = contours, .grid_mm = 1};
    const LayerSet alone[] = {{.layers = given}};
    CHECK(combined(alone, unite).info.box == Box{{8, 8, 0}, {1 << 29, 1 << 29, 0}});
    std::array<std::int32_t, 8> numbers{};
    std::array<Contour, 1> contour;
    std::array<Layer, 1> layer;
    HostArrays host{.points = numbers.data(), .point_capacity = 4, .contours = contour, .layers = layer};
    REQUIRE(Overlay().combine(host, alone).ok());
    CHECK(numbers[2] == 1 << 29);
    host.scale = 4;
    CHECK(Overlay().combine(host, alone).error().message.find("do not fit") != std::string::npos);
}
