// Offsets in steps, with joins and ends: what can be written down, and distances by brute force at random places.
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/overlay.hpp"
#include "regions/given.hpp"
#include "regions/region.hpp"
#include "rings.hpp"

using namespace lamella;
using polygons::between;
using regions::Given;
using regions::Polygon;
using regions::Polygons;

namespace {

using Place = rings::PlaceOf<double>;

SliceResult moved(const LayerSet& of, std::span<const OffsetStep> steps, const OffsetOptions& options = {},
                  const RegionRules& after = {}, const Context& context = {}) {
    SliceResult result;
    const SliceInfo info = value_of(Overlay().offset(result, of, steps, options, after, context));
    CHECK(info.contours == result.contours.size());
    require_ok(audits::structure_of(result));
    return result;
}

/// On a grid of 1 mm, as all of these; tolerances of arcs are a unit.
SliceResult moved(const Polygons& of, std::initializer_list<OffsetStep> steps, OffsetOptions options = {}) {
    const Given given(of);
    options.arc_tolerance_mm = options.arc_tolerance_mm == OffsetOptions{}.arc_tolerance_mm ? 1 : options.arc_tolerance_mm;
    return moved({.layers = given.set}, std::span(steps.begin(), steps.size()), options);
}

double area_of(const SliceResult& result, std::uint32_t part = 0) {
    double area = 0;
    for (const Contour& contour : result.contours) {
        area += contour.part == part ? contour.twice_area.to_double() / 2 : 0;
    }
    return area;
}

Polygon scaled(std::initializer_list<Point> points) {
    Polygon all(points);
    for (Point& p : all) {
        p = {p.x * 1000, p.y * 1000};
    }
    return all;
}
Polygon square(std::int32_t low, std::int32_t high) {
    return scaled({{low, low}, {high, low}, {high, high}, {low, high}});
}
Polygon hole(std::int32_t low, std::int32_t high) {
    return polygons::reversed(square(low, high));
}

double distance_to(const Polygon& line, bool closed, Place p) {
    double nearest = 1e300;
    for (std::size_t i = 0; i + (closed ? 0 : 1) < std::max<std::size_t>(line.size(), 2); ++i) {
        nearest = std::min(nearest, rings::distance(line[i % line.size()], line[(i + 1) % line.size()], p));
    }
    return nearest;
}

bool contains(const SliceResult& result, std::uint32_t part, Place p) {
    int winding = 0;
    for (const Contour& contour : result.contours) {
        winding += contour.part == part ? rings::winding(result[0].points_of(contour), p).value_or(0) : 0;
    }
    return winding > 0;
}

constexpr double pi = std::numbers::pi;

}  // namespace

TEST_CASE("offsets of few corners have the known areas", "[regions][offset]") {
    const double unit = 1e6;
    CHECK(area_of(moved({square(0, 4)}, {{1000}})) == 36 * unit);
    const double cut = 4 * std::pow(std::numbers::sqrt2 - 1, 2);
    CHECK(area_of(moved({square(0, 4)}, {{1000}}, {.join = Join::square})) / unit == Approx(36 - cut).margin(0.02));
    const SliceResult round = moved({square(0, 4)}, {{1000}}, {.join = Join::round});
    CHECK(area_of(round) / unit > 32 + pi);
    CHECK(area_of(round) / unit < 32 + pi + 4 * pi / 2 * 0.001);
    const SliceResult shrunk = moved({square(0, 4)}, {{-1000}, {-1000}, {-1000}});
    CHECK(area_of(shrunk, 0) == 4 * unit);
    CHECK(shrunk.contours.size() == 1);
    CHECK(shrunk.info.part_count == 3);
    CHECK(area_of(moved({square(0, 10), hole(4, 6)}, {{1500}})) == 169 * unit);
    CHECK(moved({square(0, 10), hole(4, 6)}, {{1500}}).contours.size() == 1);
    const Polygons apart = {scaled({{0, 0}, {4, 0}, {4, 4}, {0, 4}}), scaled({{5, 0}, {9, 0}, {9, 4}, {5, 4}})};
    CHECK(area_of(moved(apart, {{1000, false}, {-1000}})) == 36 * unit);
    CHECK(area_of(moved(apart, {{400, false}, {-400}})) == 32 * unit);
    const Polygons necked = {square(0, 6), scaled({{10, 0}, {16, 0}, {16, 6}, {10, 6}}),
                             scaled({{6, 2}, {10, 2}, {10, 4}, {6, 4}})};
    const SliceResult opened = moved(necked, {{-1500, false}, {1500}});
    CHECK(area_of(opened) == 72 * unit);
    CHECK(opened.contours.size() == 2);
    CHECK(area_of(moved(necked, {{-500, false}, {500}})) == 80 * unit);
    const Polygons slotted = {scaled({{0, 0}, {10, 0}, {10, 10}, {6, 10}, {6, 5}, {4, 5}, {4, 10}, {0, 10}})};
    CHECK(area_of(moved(slotted, {{1500}})) == 169 * unit);
    CHECK(area_of(moved(slotted, {{750}, {750}}), 1) == 169 * unit);
    CHECK(moved({}, {{1000}}).contours.empty());
}

TEST_CASE("lines have the known areas, by their ends", "[regions][offset]") {
    const double unit = 1e6;
    const Polygons line = {scaled({{0, 0}, {10, 0}})};
    const Polygons back = {scaled({{0, 0}, {10, 0}, {0, 0}})};
    CHECK(area_of(moved(line, {{1000}}, {.end = End::butt})) == 20 * unit);
    CHECK(area_of(moved(line, {{1000}}, {.end = End::square})) == 24 * unit);
    const SliceResult round = moved(line, {{1000}}, {.join = Join::round, .end = End::round});
    CHECK(area_of(round) / unit > 20 + pi);
    CHECK(area_of(round) / unit < 20 + pi * 1.002);
    CHECK(regions::region_in(moved(back, {{1000}}, {.join = Join::round, .end = End::round})) == regions::region_in(round));
    CHECK(area_of(moved({scaled({{0, 0}, {10, 0}, {10, 10}})}, {{1000}}, {.end = End::butt})) == 40 * unit);
    const Polygons dot = {scaled({{3, 3}, {3, 3}})};
    CHECK(moved(dot, {{1000}}, {.end = End::butt}).contours.empty());
    CHECK(area_of(moved(dot, {{1000}}, {.end = End::square})) == 4 * unit);
    CHECK(area_of(moved(dot, {{1000}}, {.end = End::round})) / unit == Approx(pi).epsilon(0.002));
    CHECK(area_of(moved(line, {{1000}, {-500}}, {.end = End::butt}), 1) == 9 * unit);

    // Contours of layers: closed ones are lines without ends.
    const SliceResult open = sliced(shapes::wall({0, 0}, {4, 0}), {.layer_height_mm = 1});
    const SliceResult closed = sliced(shapes::box({0, 0, 0}, {4, 4, 4}), {.layer_height_mm = 1});
    const OffsetStep half[] = {{0.5}};
    const SliceResult ring = moved({.layers = closed}, half, {.end = End::butt});
    CHECK(ring[2].area_mm2() == Approx(25 - 9));
    REQUIRE(open[2].contours[0].role == Role::open);
    CHECK(moved({.layers = open}, half, {.end = End::butt})[2].area_mm2() == Approx(4));
    CHECK(moved({.layers = open}, half, {}).contours.empty());
}

TEST_CASE("points lie in an offset by their distance, whatever the joins", "[regions][offset]") {
    std::mt19937 random(7);
    const int rounds = 400;
    for (int round = 0; round < rounds; ++round) {
        const double size = std::pow(10, between(random, 2, 6));
        const Join join = std::array{Join::miter, Join::round, Join::square}[random() % 3];
        const double distance = std::max(2.0, size * std::pow(10, between(random, -2, 0)));
        const double tolerance = std::max(1.0, distance * std::pow(10, between(random, -5, -1)));
        const OffsetOptions options{.join = join, .miter_limit = between(random, 1, 4), .arc_tolerance_mm = tolerance};
        const Polygon ring = polygons::star(random, 3 + random() % 12, 0.2 * size, size);
        const bool inwards = random() % 2 == 0;
        if (regions::region_of({ring}, FillRule::non_zero).points.size() != ring.size()) {
            continue;  // it crosses itself, where slivers may vanish
        }
        const SliceResult found = moved({ring}, {{inwards ? -distance : distance}}, options);
        const double most = join == Join::round ? distance + tolerance
                                                : distance * std::max(join == Join::miter ? options.miter_limit : 1,
                                                                      std::numbers::sqrt2 + tolerance / distance);
        for (int i = 0; i < 200; ++i) {
            const Place p = polygons::place_near(random, found.points, size, distance);
            const bool within = rings::winding(ring, p).value_or(0) != 0;
            // How far outside of what is moved: the ring where it widens, its complement where it narrows.
            const double out = within != inwards ? 0 : distance_to(ring, true, p);
            CAPTURE(round, regions::text_of({ring}), distance, inwards, int(join), tolerance, p.x, p.y, out, most);
            if (out < distance - 2) {
                REQUIRE(contains(found, 0, p) == !inwards);
            } else if (out > most + 2) {
                REQUIRE(contains(found, 0, p) == inwards);
            }
        }
    }
}

TEST_CASE("points lie around a line by their distance, where joins and ends are round", "[regions][offset]") {
    std::mt19937 random(11);
    for (int round = 0; round < 300; ++round) {
        const double size = std::pow(10, between(random, 2, 6));
        const double distance = std::max(2.0, size * std::pow(10, between(random, -2, 0)));
        const double tolerance = std::max(1.0, distance * std::pow(10, between(random, -5, -1)));
        Polygon line(1 + random() % 8);
        for (Point& p : line) {
            p = {polygons::rounded(between(random, -size, size)), polygons::rounded(between(random, -size, size))};
        }
        if (random() % 4 == 0) {
            line.push_back(line[random() % line.size()]);
        }
        const SliceResult found =
            moved({line}, {{distance}}, {.join = Join::round, .end = End::round, .arc_tolerance_mm = tolerance});
        for (int i = 0; i < 200; ++i) {
            const Place p = polygons::place_near(random, found.points, size, distance);
            const double away = distance_to(line, false, p);
            CAPTURE(round, regions::text_of({line}), distance, tolerance, p.x, p.y, away);
            if (away < distance - 2) {
                REQUIRE(contains(found, 0, p));
            } else if (away > distance + tolerance + 2) {
                REQUIRE_FALSE(contains(found, 0, p));
            }
        }
    }
}

TEST_CASE("a step begins where the one before ended, and those that are kept are parts", "[regions][offset]") {
    std::mt19937 random(3);
    for (int round = 0; round < 100; ++round) {
        const Polygons of = {polygons::star(random, 20, 20'000, 100'000), polygons::star(random, 20, 20'000, 100'000)};
        const double first = between(random, -9000, 9000);
        const double second = between(random, -9000, 9000);
        const double third = between(random, -9000, 9000);
        const OffsetOptions options{.join = std::array{Join::miter, Join::round, Join::square}[random() % 3],
                                    .arc_tolerance_mm = 20};
        const SliceResult walls = moved(of, {{first}, {second, false}, {third}}, options);
        SliceResult at = moved(of, {{first}}, options);
        CHECK(area_of(walls, 0) == area_of(at, 0));
        for (const double mm : {second, third}) {
            const OffsetStep step[] = {{mm}};
            at = moved({.layers = at}, step, options);
        }
        CHECK(area_of(walls, 1) == area_of(at, 0));
        Polygons turned = {of[1], of[0]};
        std::rotate(turned[0].begin(), turned[0].begin() + 5, turned[0].end());
        CHECK(moved(turned, {{first}, {second, false}, {third}}, options).hash() == walls.hash());
    }
}

TEST_CASE("stacks are offset layer by layer, by any threads and to any destination", "[regions][offset][threads]") {
    const SliceResult ball = sliced(shapes::octasphere({0, 0, 10}, 10, 4), {.layer_height_mm = 0.5});
    const OffsetStep steps[] = {{-0.5}, {-0.5}, {-2, false}, {2}};
    const OffsetOptions options{.join = Join::round};
    const SliceResult walls = moved({.layers = ball}, steps, options, {}, {.threads = 1});
    CHECK(walls.hash() == moved({.layers = ball}, steps, options, {}, {.threads = 5}).hash());
    CHECK(walls.size() == ball.size());
    CHECK(walls.info.part_count == 3);
    std::size_t taken = 0;
    auto take = [&](const LayerView& layer) noexcept { taken += layer.contours.size(); };
    CHECK(Overlay().offset(LayerSink{.take = take}, {.layers = ball}, steps, options).ok());
    CHECK(taken == walls.contours.size());
    const SliceResult bare = moved({.layers = ball}, steps, options, {.simplify_mm = 0.1, .drop_collinear = true});
    CHECK(bare.points.size() < walls.points.size());
    const double radius = std::sqrt(area_of(walls, 0) / pi) * walls.info.grid_mm;
    CHECK(radius > 0);
}

TEST_CASE("what cannot be offset is one clear error", "[regions][offset]") {
    SliceResult result;
    const Given of({square(0, 4)}, 0.5);
    const auto message = [&](std::vector<OffsetStep> steps, const OffsetOptions& options = {}, double grow_mm = 0) {
        return error_of(Overlay().offset(result, {.layers = of.set, .grow_mm = grow_mm}, steps, options)).message;
    };
    CHECK(message({}) == "an offset has from 1 to 65535 steps, not 0");
    CHECK(message({{1, false}}) == "no step of the offset is kept");
    CHECK(message({{1}, {0}}) == "step 1: the offset of 0 mm moves nothing");
    CHECK(message({{0.25}}).find("step 0: the offset of 0.25 mm is under the grid unit of 0.5 mm") == 0);
    CHECK(message({{1}, {5e8}}).find("step 1: the offset of 5e+08 mm is beyond the grid") == 0);
    CHECK(message({{1e8}, {1e8}, {1e8}}).find("step 1: contours that extend to") == 0);
    CHECK(message({{std::nan("")}}).find("step 0: ") == 0);
    CHECK(message({{1}}, {.arc_tolerance_mm = 0}) == "the arc tolerance must be finite and above 0, not 0 mm");
    CHECK(message({{1e6}}, {.join = Join::round, .arc_tolerance_mm = 0.1})
              .find("step 0: an arc tolerance of 0.1 mm is too fine") == 0);
    CHECK(message({{1}}, {.miter_limit = 0.5}).find("step 0: ") == 0);
    CHECK(message({{1}}, {.join = Join(9)}) == "the join or the end of an offset is none of its choices");
    CHECK(message({{-1}}, {.end = End::butt}) ==
          "step 0: lines have no inside: the first offset must be above 0, not -1 mm");
    CHECK(message({{1}}, {.end = End::butt}, 1) == "lines cannot be grown first: they bound no region");
}
