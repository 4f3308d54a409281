// Regions of random polygons, judged in exact arithmetic. The long test runs the short one on a hundred thousand.
#include <algorithm>
#include <array>
#include <random>

#include <catch2/catch.hpp>

#include "exact/polygons.hpp"
#include "exact/region_judge.hpp"
#include "regions/lattice.hpp"

using lamella::FillRule;
using regions::Polygons;

namespace {

constexpr std::array winding_rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive};

/// Empty if all that must hold for a region holds.
std::string judge(const Polygons& polygons, FillRule rule, std::mt19937& random) {
    lamella::RegionRules rules;
    rules.fill_rule = rule;
    rules.drop_collinear = random() % 2 == 0;
    const lamella::LayerContours found = regions::region_of(polygons, rules);
    std::string fault = regions::fault_in(found);
    if (fault.empty()) {
        fault = exact::fault_in_region(polygons, rule, found);
    }
    if (fault.empty()) {
        fault = regions::dependence_on_order(polygons, rules, found, random);
    }
    if (fault.empty() && rule == FillRule::non_zero) {
        const regions::Region outermost = regions::canonical(regions::without_holes(regions::region_in(found)));
        fault = regions::difference(outermost, regions::region_in(regions::region_of(polygons, FillRule::outermost)));
        fault = fault.empty() ? "" : "by outermost, " + fault;
    }
    return fault.empty() ? "" : std::string(lamella::name_of(rule)) + ": " + fault + "\nof " + regions::text_of(polygons);
}

std::size_t between(std::mt19937& random, std::size_t low, std::size_t high) {
    return low + random() % (high - low + 1);
}

/// Of 1,000 layers 800 have 3 to 12 points, 170 up to 40, 28 up to 150, and two up to 1,000.
std::size_t random_size(std::mt19937& random) {
    const auto of_thousand = random() % 1'000;
    if (of_thousand < 800) {
        return between(random, 3, 12);
    }
    if (of_thousand < 970) {
        return between(random, 13, 40);
    }
    return of_thousand < 998 ? between(random, 41, 150) : between(random, 151, 1'000);
}

void judge_random_polygons(std::uint32_t seed, std::size_t layers) {
    std::mt19937 random(seed);
    std::size_t points = 0;
    for (std::size_t number = 0; number < layers; ++number) {
        const Polygons polygons = exact::random_polygons(random, random_size(random));
        const std::string fault = judge(polygons, winding_rules[number % winding_rules.size()], random);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << fault);
        }
        for (const regions::Polygon& polygon : polygons) {
            points += polygon.size();
        }
    }
    CHECK(points > 10 * layers);
}

void judge_small_lattices(std::uint32_t seed, std::size_t layers) {
    std::mt19937 random(seed);
    for (std::size_t number = 0; number < layers; ++number) {
        const Polygons polygons = exact::random_on_small_lattice(random);
        const FillRule rule =
            std::array{FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost}[number % 4];
        const regions::Region found = regions::region_in(regions::region_of(polygons, rule));
        const std::string fault = regions::difference(exact::region_on_grid(polygons, rule), found);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << lamella::name_of(rule) << ": " << fault << "\nof "
                          << regions::text_of(polygons));
        }
    }
}

}  // namespace

TEST_CASE("regions of random polygons lie within a unit of the exact ones, and their contours as they must", "[regions]") {
    judge_random_polygons(1, 500);
}

TEST_CASE("regions whose crossings all lie on the grid are exact", "[regions]") {
    judge_small_lattices(1, 500);
}

TEST_CASE("regions of 100,000 layers of random polygons are right", "[regions_long]") {
    judge_random_polygons(2, 100'000);
}

TEST_CASE("20,000 regions whose crossings all lie on the grid are exact", "[regions_long]") {
    judge_small_lattices(2, 20'000);
}

TEST_CASE("the exact judge and the lattice judge expect the same regions", "[regions]") {
    std::mt19937 random(4);
    for (int number = 0; number < 150; ++number) {
        const Polygons polygons = regions::random_octilinear(random, 6);
        const regions::Lattice lattice(polygons, 6);
        const regions::Placement placement = regions::random_placement(random, 6);
        for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost}) {
            const regions::Region expected = placement.placed(lattice.region(rule));
            INFO(lamella::name_of(rule) << " of " << regions::text_of(polygons));
            REQUIRE(regions::difference(expected, exact::region_on_grid(placement.placed(polygons), rule)) == "");
        }
    }
}

TEST_CASE("the exact judge of regions finds every kind of fault", "[regions]") {
    const Polygons polygons{{{0, 0}, {100, 10}, {90, 80}, {10, 90}}, {{50, 50}, {300, 60}, {290, 70}, {60, 200}}};
    const auto fault = [&](auto&& damage) {
        Polygons rings = regions::rings_of(regions::region_of(polygons, FillRule::non_zero));
        REQUIRE(rings.size() == 1);
        damage(rings);
        return exact::fault_in_rings(polygons, FillRule::non_zero, rings);
    };
    using Rings = Polygons&;
    CHECK(fault([](Rings) {}) == "");
    CHECK(fault([](Rings r) { r[0][0].x -= 1; }) == "");
    CHECK(fault([](Rings r) { r[0][0].x -= 3; }) != "");
    CHECK(fault([](Rings r) { r[0].erase(r[0].begin() + 1); }) != "");
    CHECK(fault([](Rings r) { r.push_back(r[0]); }) != "");
    CHECK(fault([](Rings r) { std::reverse(r[0].begin(), r[0].end()); }) != "");
    CHECK(fault([](Rings r) { r.clear(); }) != "");
    CHECK(fault([](Rings r) { r.push_back({{400, 400}, {403, 400}, {403, 403}}); }) != "");
    CHECK(fault([](Rings r) { r.push_back({{40, 40}, {43, 43}, {43, 40}}); }) != "");
    CHECK(fault([](Rings r) { std::swap(r[0][1], r[0][2]); }) != "");
}
