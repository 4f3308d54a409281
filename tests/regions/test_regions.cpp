// Regions where their judges and their rules matter. What regions must be is judged by tests/exact and tests/fuzz.
#include <algorithm>
#include <array>
#include <random>

#include <catch2/catch.hpp>

#include "regions/region.hpp"

using lamella::FillRule;
using lamella::SliceResult;
using regions::Polygons;
using regions::Region;

namespace {

regions::Polygon box(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height) {
    return {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
}

regions::Polygon square(std::int32_t low, std::int32_t high) {
    return box(low, low, high - low, high - low);
}

/// Rectangles on a few places, so that their sides often coincide; some run backwards.
Polygons random_boxes(std::mt19937& random) {
    const auto draw = [&](int most) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(most)); };
    Polygons boxes;
    for (int count = 2 + draw(6); count > 0; --count) {
        boxes.push_back(box(10 * draw(9), 10 * draw(9), 10 + 10 * draw(6), 10 + 10 * draw(6)));
        if (draw(3) == 0) {
            std::reverse(boxes.back().begin(), boxes.back().end());
        }
    }
    return boxes;
}

}  // namespace

TEST_CASE("an outer contour in a hole has it as parent where both touch in a point with all sides to the right",
          "[regions]") {
    const Polygons polygons{square(0, 12), {{1, 1}, {1, 11}, {6, 11}, {6, 6}, {11, 11}, {11, 1}}, {{6, 6}, {8, 4}, {8, 6}}};
    const SliceResult region = regions::region_of(polygons, FillRule::even_odd);
    CHECK(regions::broken_promise(region) == "");
    REQUIRE(region.contours.size() == 3);
    CHECK(region.contours[2].parent == 1);
}

TEST_CASE("an edge that rounding lays along its neighbour leaves no spike", "[regions]") {
    // (-2, 2) to (1, 4) passes the pixel of (0, 4), to which the next edge leads back.
    const Polygons polygons{{{0, 0}, {-2, 2}, {1, 4}, {0, 4}, {0, 9}, {10, 13}}, {{10, 14}, {16, 8}, {8, -7}}};
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero}) {
        CHECK(regions::fault_in(regions::region_of(polygons, rule)) == "");
    }
}

TEST_CASE("the comparison of regions finds every kind of difference", "[regions]") {
    const Polygons polygons{square(0, 24), square(2, 22), square(4, 20), square(6, 18), square(8, 12), square(12, 16)};
    const Region right = regions::region_in(regions::region_of(polygons, FillRule::even_odd));
    REQUIRE(right.size() == 6);
    const auto differs = [&](auto&& damage) {
        Region other = right;
        damage(other);
        return !regions::difference(right, regions::canonical(other)).empty();
    };
    CHECK_FALSE(differs([](Region&) {}));
    CHECK_FALSE(differs([](Region& r) { std::rotate(r[2].corners.begin(), r[2].corners.begin() + 1, r[2].corners.end()); }));
    CHECK_FALSE(differs([](Region& r) { r[0].corners.insert(r[0].corners.begin() + 1, {5, 0}); }));
    CHECK(differs([](Region& r) { r[3].corners[0].x += 1; }));
    CHECK(differs([](Region& r) { r[1].hole = false; }));
    CHECK(differs([](Region& r) { r[2].parent = -1; }));
    CHECK(differs([](Region& r) { r.pop_back(); }));
    CHECK(differs([](Region& r) {
        // Two solids that touch, as one contour.
        r[4].corners = {{8, 8}, {12, 8}, {12, 12}, {16, 12}, {16, 16}, {12, 16}, {12, 12}, {8, 12}};
        r.pop_back();
    }));
}

TEST_CASE("the judges of regions find what a region must not have", "[regions]") {
    const Polygons polygons{square(0, 40), square(10, 30), {{15, 15}, {25, 15}, {25, 20}, {25, 25}, {15, 25}}};
    const auto faulty = [&](auto&& damage) {
        SliceResult region = regions::region_of(polygons, FillRule::even_odd);
        REQUIRE(region.contours.size() == 3);
        damage(region);
        return !regions::fault_in(region).empty();
    };
    CHECK_FALSE(faulty([](SliceResult&) {}));
    CHECK(faulty([](SliceResult& r) { r.contours[1].parent = -1; }));
    CHECK(faulty([](SliceResult& r) { r.contours[2].parent = 0; }));
    CHECK(faulty([](SliceResult& r) { r.contours[2].parent = 7; }));
    CHECK(faulty([](SliceResult& r) { r.contours[1].role = lamella::Role::outer; }));
    CHECK(faulty([](SliceResult& r) { r.contours[1].orientation = 1; }));
    CHECK(faulty([](SliceResult& r) { r.contours[0].twice_area.low ^= 2; }));
    CHECK(faulty([](SliceResult& r) { r.points[1] = r.points[0]; }));
    CHECK(faulty([](SliceResult& r) { r.points[10] = {25, 12}; }));
    CHECK(faulty([](SliceResult& r) { std::rotate(&r.points[0], &r.points[1], &r.points[4]); }));
    CHECK(faulty([](SliceResult& r) { std::swap(r.contours[0], r.contours[2]); }));
    CHECK(faulty([](SliceResult& r) { r.contours[2].point_count -= 1; }));
}

TEST_CASE("the largest outer contour alone stays, with its holes", "[regions]") {
    std::mt19937 random(3);
    for (int number = 0; number < 1200; ++number) {
        const Polygons polygons = random_boxes(random);
        const FillRule rule = std::array{FillRule::even_odd, FillRule::non_zero, FillRule::positive,
                                         FillRule::outermost}[static_cast<std::size_t>(number) % 4];
        const SliceResult whole = regions::region_of(polygons, rule);
        const Region all = regions::region_in(whole);
        std::size_t largest = 0;
        for (std::size_t r = 1; r < all.size(); ++r) {
            largest = regions::twice_area(all[r].corners) > regions::twice_area(all[largest].corners) ? r : largest;
        }
        Region kept;
        for (std::size_t r = 0; r < all.size(); ++r) {
            if (r == largest || (all[r].hole && all[r].parent == static_cast<std::int64_t>(largest))) {
                kept.push_back({all[r].corners, all[r].hole, all[r].hole ? 0 : -1});
            }
        }
        lamella::RegionRules rules;
        rules.fill_rule = rule;
        rules.largest_only = true;
        const SliceResult found = regions::region_of(polygons, rules);
        INFO(lamella::name_of(rule) << " of " << regions::text_of(polygons));
        REQUIRE(regions::broken_promise(whole) == "");
        REQUIRE(regions::fault_in(found) == "");
        REQUIRE(regions::difference(regions::canonical(kept), regions::region_in(found)) == "");
        REQUIRE(regions::dependence_on_order(polygons, rules, found, random) == "");
    }
}
