// Regions of contours on lattices, judged triangle by triangle. A separate program judges hundreds of thousands.
#include <algorithm>
#include <array>
#include <random>

#include <catch2/catch.hpp>

#include "regions/lattice.hpp"

using lamella::FillRule;
using regions::Lattice;
using regions::Polygons;
using regions::Region;

namespace {

constexpr std::array all_rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost};

Region on_lattice(const Polygons& polygons, FillRule rule) {
    return Lattice(polygons, 12).region(rule);
}

regions::Polygon square(std::int32_t low, std::int32_t high) {
    return {{low, low}, {high, low}, {high, high}, {low, high}};
}

}  // namespace

TEST_CASE("regions on lattices are exact in area and structure, whatever the order of contours", "[regions]") {
    std::mt19937 random(12);
    for (int number = 0; number < 1'500; ++number) {
        const std::int32_t size = 3 + number % 10;
        const Polygons polygons = regions::random_octilinear(random, size);
        const std::string fault = regions::judge_octilinear(polygons, size, regions::random_placement(random, size), random);
        INFO("layer " << number);
        REQUIRE(fault == "");
    }
}

TEST_CASE("an outer contour in a hole has it as parent where both touch in a point with all sides to the right",
          "[regions]") {
    const Polygons polygons{square(0, 12), {{1, 1}, {1, 11}, {6, 11}, {6, 6}, {11, 11}, {11, 1}}, {{6, 6}, {8, 4}, {8, 6}}};
    std::mt19937 random(1);
    CHECK(regions::judge_octilinear(polygons, 12, {4, {0, 0}}, random) == "");
    REQUIRE(on_lattice(polygons, FillRule::even_odd).size() == 3);
    CHECK(on_lattice(polygons, FillRule::even_odd)[2].parent == 1);
}

TEST_CASE("an edge that rounding lays along its neighbour leaves no spike", "[regions]") {
    // (-2, 2) to (1, 4) passes the pixel of (0, 4), to which the next edge leads back.
    const Polygons polygons{{{0, 0}, {-2, 2}, {1, 4}, {0, 4}, {0, 9}, {10, 13}}, {{10, 14}, {16, 8}, {8, -7}}};
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero}) {
        CHECK(regions::fault_in(regions::region_of(polygons, rule)) == "");
    }
}

TEST_CASE("the lattice judge finds every kind of difference", "[regions]") {
    const Polygons polygons{square(0, 12), square(1, 11), square(2, 10), square(3, 9), square(4, 6), square(6, 8)};
    const Region right = on_lattice(polygons, FillRule::even_odd);
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
        lamella::LayerContours contours = regions::region_of(polygons, FillRule::even_odd);
        REQUIRE(contours.contours.size() == 3);
        damage(contours);
        return !regions::fault_in(contours).empty();
    };
    using lamella::LayerContours;
    CHECK_FALSE(faulty([](LayerContours&) {}));
    CHECK(faulty([](LayerContours& r) { r.contours[1].parent = -1; }));
    CHECK(faulty([](LayerContours& r) { r.contours[2].parent = 0; }));
    CHECK(faulty([](LayerContours& r) { r.contours[2].parent = 7; }));
    CHECK(faulty([](LayerContours& r) { r.contours[1].role = lamella::Role::outer; }));
    CHECK(faulty([](LayerContours& r) { r.contours[1].orientation = 1; }));
    CHECK(faulty([](LayerContours& r) { r.contours[0].twice_area.low ^= 2; }));
    CHECK(faulty([](LayerContours& r) { r.points[1] = r.points[0]; }));
    CHECK(faulty([](LayerContours& r) { r.points[10] = {25, 12}; }));
    CHECK(faulty([](LayerContours& r) { std::rotate(&r.points[0], &r.points[1], &r.points[4]); }));
    CHECK(faulty([](LayerContours& r) { std::swap(r.contours[0], r.contours[2]); }));
    CHECK(faulty([](LayerContours& r) { r.contours[2].point_count -= 1; }));
}

TEST_CASE("the largest outer contour alone stays, with its holes", "[regions]") {
    std::mt19937 random(3);
    for (int number = 0; number < 300; ++number) {
        const Polygons polygons = regions::random_octilinear(random, 9);
        const regions::Placement placement = regions::random_placement(random, 9);
        for (const FillRule rule : all_rules) {
            const Region all = placement.placed(Lattice(polygons, 9).region(rule));
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
            const lamella::LayerContours found = regions::region_of(placement.placed(polygons), rules);
            INFO(lamella::name_of(rule) << " of " << regions::text_of(polygons));
            REQUIRE(regions::fault_in(found) == "");
            REQUIRE(regions::difference(regions::canonical(kept), regions::region_in(found)) == "");
        }
    }
}
