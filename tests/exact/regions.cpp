// Regions of random polygons and combinations of such regions, judged in exact arithmetic. The long tests run the short ones
// on many thousands.
#include <array>
#include <functional>
#include <iterator>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "exact/judge.hpp"
#include "lamella/overlay.hpp"

using lamella::FillRule;
using regions::Point;
using regions::Polygon;
using regions::Polygons;

namespace {

std::int64_t draw(std::mt19937& random, std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
}

std::int32_t on_grid(double value) {
    constexpr double limit = lamella::grid_limit;
    return static_cast<std::int32_t>(std::clamp(value, -limit, limit));
}

/// Where polygons lie: within `reach` of the centre, and never off the grid.
struct Area {
    double reach, centre_x, centre_y;

    Point point(double dx, double dy) const { return {on_grid(centre_x + dx), on_grid(centre_y + dy)}; }
    Point random_point(std::mt19937& random) const {
        return point(polygons::between(random, -reach, reach), polygons::between(random, -reach, reach));
    }
};

Area random_area(std::mt19937& random, std::size_t points) {
    // Few units only for few points: a lattice full of edges is all crossings.
    constexpr std::array<std::int32_t, 6> reaches{4, 12, 100, 10'000, 1 << 20, lamella::grid_limit};
    const std::size_t first = points > 100 ? 3 : (points > 20 ? 1 : 0);
    const std::int32_t reach = reaches[first + random() % (reaches.size() - first)];
    const double room = lamella::grid_limit - reach;
    return {static_cast<double>(reach), std::round(polygons::between(random, -room, room)),
            std::round(polygons::between(random, -room, room))};
}

/// Points around the centre, all the same way round from one to the next: `rounds` times in all, every other one at `inner`
/// of the radius, each moved by up to `jitter`.
Polygon points_around(std::mt19937& random, const Area& area, std::size_t points, double rounds, double inner,
                      double jitter) {
    Polygon polygon;
    for (std::size_t i = 0; i < points; ++i) {
        const double angle = 2 * std::numbers::pi * rounds * static_cast<double>(i) / static_cast<double>(points);
        const double radius = area.reach * (i % 2 == 0 ? 0.8 : 0.8 * inner);
        polygon.push_back(area.point(radius * std::cos(angle) + polygons::between(random, -jitter, jitter),
                                     radius * std::sin(angle) + polygons::between(random, -jitter, jitter)));
    }
    return polygon;
}

Polygon moved(std::mt19937& random, Polygon polygon) {
    const double dx = static_cast<double>(draw(random, -2, 2));
    const double dy = static_cast<double>(draw(random, -2, 2));
    for (Point& point : polygon) {
        point = {on_grid(point.x + dx), on_grid(point.y + dy)};
    }
    return polygon;
}

/// A walk of short steps, a star, whose edges cross in rings, a rectangle, or points anywhere. These last only few: their
/// crossings would grow with the square.
Polygon random_polygon(std::mt19937& random, const Area& area, std::size_t points) {
    const auto kind = points > 150 ? random() % 3 : random() % 8;
    if (kind < 2) {
        return points_around(random, area, points, 1, 1, std::max(2.0, 4 * area.reach / static_cast<double>(points)));
    }
    if (kind == 2) {
        return points_around(random, area, points, static_cast<double>(draw(random, 1, 4)), 0.5, 0);
    }
    if (kind == 3) {
        const Point a = area.random_point(random);
        const Point b = area.random_point(random);
        return polygons::box(a.x, a.y, b.x, b.y);
    }
    Polygon polygon(points);
    std::generate(polygon.begin(), polygon.end(), [&] { return area.random_point(random); });
    return polygon;
}

/// Another polygon, or one of those before, which then share their edges or lie close to each other.
template <class Make>
Polygons several(std::mt19937& random, std::int64_t most, const Make& make) {
    Polygons polygons;
    for (std::int64_t count = draw(random, 1, most); count > 0; --count) {
        if (polygons.empty() || random() % 4 != 0) {
            polygons.push_back(make());
        } else {
            polygons.push_back(polygons[random() % polygons.size()]);
        }
        if (random() % 3 == 0) {
            std::reverse(polygons.back().begin(), polygons.back().end());
        }
    }
    return polygons;
}

/// One to four polygons of together about `points` points, on a range of the grid from a few units up to all of it. Some are
/// given twice, a little moved or backwards.
Polygons random_polygons(std::mt19937& random, const Area& area, std::size_t points) {
    const std::int64_t most = points > 400 ? 1 : 4;
    const std::size_t each = std::max<std::size_t>(3, points / static_cast<std::size_t>((most + 1) / 2));
    Polygons polygons = several(random, most, [&] { return random_polygon(random, area, each); });
    if (random() % 4 == 0) {
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

constexpr std::array rules{FillRule::even_odd, FillRule::non_zero, FillRule::positive, FillRule::outermost};

/// Empty if all that must hold for a region holds.
std::string judge(const Polygons& polygons, FillRule rule, std::mt19937& random) {
    const lamella::RegionRules asked{.fill_rule = rule, .drop_collinear = random() % 2 == 0};
    const lamella::SliceResult found = regions::region_of(polygons, asked);
    std::string fault = regions::fault_in(found);
    fault = fault.empty() ? exact::fault_in_region(polygons, rule, found) : fault;
    fault = fault.empty() ? regions::dependence_on_order(polygons, asked, found, random) : fault;
    if (fault.empty() && rule == FillRule::non_zero) {
        const regions::Region outermost = regions::canonical(regions::without_holes(regions::region_in(found)));
        fault = regions::difference(outermost, regions::region_in(regions::region_of(polygons, FillRule::outermost)));
        fault = fault.empty() ? "" : "by outermost, " + fault;
    }
    return fault.empty() ? "" : std::string(lamella::name_of(rule)) + ": " + fault + "\nof " + regions::text_of(polygons);
}

/// In 1,000 layers 800 have 3 to 12 points, 170 up to 40, 28 up to 150, and two up to 1,000.
std::size_t random_size(std::mt19937& random) {
    const auto of_thousand = random() % 1'000;
    const auto most = of_thousand < 800 ? 12 : (of_thousand < 970 ? 40 : (of_thousand < 998 ? 150 : 1'000));
    return static_cast<std::size_t>(draw(random, 3, most));
}

void judge_random_polygons(std::uint32_t seed, std::size_t layers) {
    std::mt19937 random(seed);
    std::size_t points = 0;
    for (std::size_t number = 0; number < layers; ++number) {
        const std::size_t size = random_size(random);
        const Polygons polygons = random_polygons(random, random_area(random, size), size);
        const std::string fault = judge(polygons, rules[number % 3], random);
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
        const FillRule rule = rules[number % rules.size()];
        const regions::Region found = regions::region_in(regions::region_of(polygons, rule));
        const std::string fault = regions::difference(exact::region_on_grid(polygons, rule), found);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << lamella::name_of(rule) << ": " << fault << "\nof "
                          << regions::text_of(polygons));
        }
    }
}

/// Contours whose winding number by `rule` is that of a combination of regions, which wind once around what they hold.
struct AsPolygons {
    Polygons polygons;
    FillRule rule = FillRule::positive;

    AsPolygons& plus(const Polygons& rings) {
        polygons.insert(polygons.end(), rings.begin(), rings.end());
        return *this;
    }
    AsPolygons& minus(const Polygons& rings) {
        std::transform(rings.begin(), rings.end(), std::back_inserter(polygons), polygons::reversed);
        return *this;
    }
    /// Everywhere that the rings reach.
    AsPolygons& minus_one() {
        Point low{lamella::grid_limit, lamella::grid_limit};
        Point high{-lamella::grid_limit, -lamella::grid_limit};
        for (const Polygon& ring : polygons) {
            for (const Point p : ring) {
                low = {std::min(low.x, p.x), std::min(low.y, p.y)};
                high = {std::max(high.x, p.x), std::max(high.y, p.y)};
            }
        }
        return low.x < high.x && low.y < high.y ? minus({polygons::box(low.x, low.y, high.x, high.y)}) : *this;
    }
};

/// A rule of three sets, a, b and c, and the same in winding numbers of their regions.
struct Combined {
    const char* name;
    std::array<std::uint32_t, 8> labels;  ///< by membership; of which label 1 is judged
    std::function<AsPolygons(const Polygons& a, const Polygons& b, const Polygons& c)> expected;
};
const std::array<Combined, 6> combinations = {{
    {"all united", {0, 1, 1, 1, 1, 1, 1, 1}, [](auto& a, auto& b, auto& c) { return AsPolygons().plus(a).plus(b).plus(c); }},
    {"a without b", {0, 1, 0, 0, 0, 1, 0, 0}, [](auto& a, auto& b, auto&) { return AsPolygons().plus(a).minus(b); }},
    {"a without b and c",
     {0, 1, 2, 2, 3, 3, 0, 2},
     [](auto& a, auto& b, auto& c) { return AsPolygons().plus(a).minus(b).minus(c); }},
    {"a and b", {0, 2, 3, 1, 0, 2, 3, 1}, [](auto& a, auto& b, auto&) { return AsPolygons().plus(a).plus(b).minus_one(); }},
    {"a and b without c",
     {0, 0, 0, 1, 0, 0, 0, 2},
     [](auto& a, auto& b, auto& c) { return AsPolygons().plus(a).plus(b).minus_one().minus(c); }},
    {"an odd number",
     {0, 1, 1, 0, 1, 0, 0, 1},
     [](auto& a, auto& b, auto& c) {
         AsPolygons all = AsPolygons().plus(a).plus(b).plus(c);
         all.rule = FillRule::even_odd;
         return all;
     }},
}};

/// Contours of label 1. Throws where they cannot be had.
Polygons combined_rings(std::span<const lamella::SliceResult> regions, const Combined& combination) {
    std::vector<lamella::LayerSet> sets;
    for (const lamella::SliceResult& region : regions) {
        sets.push_back({.layers = region});
    }
    lamella::SliceResult result;
    lamella::Overlay overlay;
    const auto done = overlay.combine(result, sets, {.labels = combination.labels});
    if (!done) {
        throw std::runtime_error(done.error().message);
    }
    Polygons rings;
    for (const lamella::Contour& contour : result.contours) {
        const auto points = result.points_of(contour);
        if (contour.part == 0) {
            rings.emplace_back(points.begin(), points.end());
        }
    }
    return rings;
}

/// Of three regions each: differences lie in a band of a unit along their edges, and together are no larger than it.
void judge_combinations(std::uint32_t seed, std::size_t layers) {
    std::mt19937 random(seed);
    std::size_t found = 0;
    for (std::size_t number = 0; number < layers; ++number) {
        const std::size_t size = std::min<std::size_t>(random_size(random), 150);
        const Area area = random_area(random, size);
        std::vector<lamella::SliceResult> regions;
        std::vector<Polygons> rings;
        for (int set = 0; set < 3; ++set) {
            regions.push_back(regions::region_of(random_polygons(random, area, size), rules[random() % 3]));
            rings.push_back(regions::rings_of(regions.back()));
        }
        const Combined& combination = combinations[number % combinations.size()];
        const AsPolygons expected = combination.expected(rings[0], rings[1], rings[2]);
        const Polygons answer = combined_rings(regions, combination);
        const std::string fault = exact::fault_in_rings(expected.polygons, expected.rule, answer);
        if (!fault.empty()) {
            FAIL("layer " << number << ", " << combination.name << ": " << fault << "\nof " << regions::text_of(rings[0])
                          << "\nand " << regions::text_of(rings[1]) << "\nand " << regions::text_of(rings[2]));
        }
        found += answer.size();
    }
    CHECK(found > layers);
}

}  // namespace

TEST_CASE("combinations of random regions lie within a unit of the exact ones", "[regions]") {
    judge_combinations(3, 300);
}

TEST_CASE("50,000 combinations of random regions are right", "[regions_long]") {
    judge_combinations(4, 50'000);
}

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
