// Regions of random polygons, judged in exact arithmetic. The long test runs the short one on a hundred thousand.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "exact/region_judge.hpp"

using lamella::FillRule;
using regions::Point;
using regions::Polygon;
using regions::Polygons;

namespace {

std::int64_t draw(std::mt19937& random, std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
}

bool one_in(std::mt19937& random, unsigned times) {
    return random() % times == 0;
}

/// Where polygons lie: within `reach` of the centre, and never off the grid.
struct Area {
    std::int64_t reach;
    std::int64_t centre_x, centre_y;

    Point point(std::int64_t dx, std::int64_t dy) const {
        const auto within = [](std::int64_t value) {
            return static_cast<std::int32_t>(std::clamp<std::int64_t>(value, -lamella::grid_limit, lamella::grid_limit));
        };
        return {within(centre_x + dx), within(centre_y + dy)};
    }
    Point random_point(std::mt19937& random) const {
        return point(draw(random, -reach, reach), draw(random, -reach, reach));
    }
};

Area random_area(std::mt19937& random, std::size_t points) {
    // Few units only for few points: a lattice full of edges is all crossings.
    constexpr std::array<std::int64_t, 6> reaches{4, 12, 100, 10'000, 1 << 20, lamella::grid_limit};
    const std::size_t first = points > 100 ? 3 : (points > 20 ? 1 : 0);
    const std::int64_t reach = reaches[first + random() % (reaches.size() - first)];
    const std::int64_t room = lamella::grid_limit - reach;
    return {reach, draw(random, -room, room), draw(random, -room, room)};
}

Polygon anywhere(std::mt19937& random, const Area& area, std::size_t points) {
    Polygon polygon(points);
    std::generate(polygon.begin(), polygon.end(), [&] { return area.random_point(random); });
    return polygon;
}

/// Steps of about a circle's circumference through `points`, so that few of them cross.
Polygon walk(std::mt19937& random, const Area& area, std::size_t points) {
    const std::int64_t step = std::max<std::int64_t>(2, 4 * area.reach / static_cast<std::int64_t>(points));
    Polygon polygon;
    for (std::size_t i = 0; i < points; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(points);
        const double radius = static_cast<double>(area.reach) * 0.8;
        polygon.push_back(area.point(static_cast<std::int64_t>(radius * std::cos(angle)) + draw(random, -step, step),
                                     static_cast<std::int64_t>(radius * std::sin(angle)) + draw(random, -step, step)));
    }
    return polygon;
}

/// Every point the same way round from the one before it: edges cross in rings.
Polygon star(std::mt19937& random, const Area& area, std::size_t points) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(draw(random, 1, 4)) / static_cast<double>(points);
    Polygon polygon;
    for (std::size_t i = 0; i < points; ++i) {
        const double radius = static_cast<double>(area.reach) * (i % 2 == 0 ? 1.0 : 0.5);
        const double angle = turn * static_cast<double>(i);
        polygon.push_back(area.point(static_cast<std::int64_t>(radius * std::cos(angle)),
                                     static_cast<std::int64_t>(radius * std::sin(angle))));
    }
    return polygon;
}

Polygon rectangle(std::mt19937& random, const Area& area) {
    const Point a = area.random_point(random);
    const Point b = area.random_point(random);
    return {a, {b.x, a.y}, b, {a.x, b.y}};
}

Polygon moved(std::mt19937& random, Polygon polygon) {
    const auto by = [&] { return static_cast<std::int32_t>(draw(random, -2, 2)); };
    const Point all{by(), by()};
    for (Point& point : polygon) {
        point = {std::clamp(point.x + all.x, -lamella::grid_limit, lamella::grid_limit),
                 std::clamp(point.y + all.y, -lamella::grid_limit, lamella::grid_limit)};
    }
    return polygon;
}

Polygon random_polygon(std::mt19937& random, const Area& area, std::size_t points) {
    if (points > 150) {  // anywhere: their crossings would grow with the square
        return one_in(random, 2) ? walk(random, area, points) : star(random, area, points);
    }
    switch (random() % 8) {
        case 0:
            return rectangle(random, area);
        case 1:
            return star(random, area, points);
        case 2:
        case 3:
            return walk(random, area, points);
        default:
            return anywhere(random, area, points);
    }
}

/// Another polygon, or one of those before, which then share their edges or lie close to each other.
template <class Make>
Polygons several(std::mt19937& random, std::int64_t most, const Make& make) {
    Polygons polygons;
    for (std::int64_t count = draw(random, 1, most); count > 0; --count) {
        if (polygons.empty() || !one_in(random, 4)) {
            polygons.push_back(make());
        } else {
            polygons.push_back(polygons[random() % polygons.size()]);
        }
        if (one_in(random, 3)) {
            std::reverse(polygons.back().begin(), polygons.back().end());
        }
    }
    return polygons;
}

/// One to four polygons of together about `points` points, on a range of the grid from a few units up to all of it: random
/// ones, whose edges cross each other; walks of short steps; stars; rectangles. Some are given twice, a little moved or
/// backwards.
Polygons random_polygons(std::mt19937& random, std::size_t points) {
    const Area area = random_area(random, points);
    const std::int64_t most = points > 400 ? 1 : 4;
    const std::size_t each = std::max<std::size_t>(3, points / static_cast<std::size_t>((most + 1) / 2));
    Polygons polygons = several(random, most, [&] { return random_polygon(random, area, each); });
    if (one_in(random, 4)) {
        polygons.push_back(moved(random, polygons[random() % polygons.size()]));
    }
    return polygons;
}

/// One to four polygons on the lattice 0 to 3, with edges in all directions that it has, some given twice or backwards. All
/// crossings lie on the grid: `cell` is divisible by every determinant of two directions.
constexpr std::int32_t cell = 360'360;
Polygons random_on_small_lattice(std::mt19937& random) {
    const auto on_lattice = [&] { return static_cast<std::int32_t>(draw(random, 0, 3)) * cell; };
    return several(random, 4, [&] {
        Polygon polygon(static_cast<std::size_t>(draw(random, 3, 9)));
        std::generate(polygon.begin(), polygon.end(), [&] { return Point{on_lattice(), on_lattice()}; });
        return polygon;
    });
}

constexpr std::array winding_rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive};

/// Empty if all that must hold for a region holds.
std::string judge(const Polygons& polygons, FillRule rule, std::mt19937& random) {
    lamella::RegionRules rules;
    rules.fill_rule = rule;
    rules.drop_collinear = random() % 2 == 0;
    const lamella::SliceResult found = regions::region_of(polygons, rules);
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

/// In 1,000 layers 800 have 3 to 12 points, 170 up to 40, 28 up to 150, and two up to 1,000.
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
        const Polygons polygons = random_polygons(random, random_size(random));
        const std::string fault = judge(polygons, winding_rules[number % winding_rules.size()], random);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << fault);
        }
        for (const Polygon& polygon : polygons) {
            points += polygon.size();
        }
    }
    CHECK(points > 10 * layers);
}

void judge_small_lattices(std::uint32_t seed, std::size_t layers) {
    std::mt19937 random(seed);
    for (std::size_t number = 0; number < layers; ++number) {
        const Polygons polygons = random_on_small_lattice(random);
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
