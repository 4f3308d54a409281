// Measures of sections: shapes whose numbers are known, lattices counted cell by cell, diameters of all pairs of points.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "base/numbers.hpp"
#include "c/call.hpp"
#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"
#include "lamella/measures.hpp"

using namespace lamella;
using polygons::box;
using polygons::reversed;
using polygons::Ring;
using polygons::Rings;

namespace {

/// One layer on a grid of 1 mm.
SliceResult region(const Rings& rings, FillRule rule = FillRule::positive) {
    const std::vector<std::span<const Point>> spans(rings.begin(), rings.end());
    return value_of(region_of(spans, {.fill_rule = rule}, 1));
}

/// One layer of a contour as it runs, which no rule has made regions of.
SliceResult as_walked(const Ring& ring) {
    SliceResult result;
    result.info.grid_mm = 1;
    result.layers.resize_discarding(1);
    result.layers[0] = {.contour_count = 1};
    result.contours.resize_discarding(1);
    result.contours[0] = {.twice_area = to_integer128(rings::twice_area(ring)), .point_count = std::uint32_t(ring.size())};
    result.points.resize_discarding(ring.size());
    std::copy(ring.begin(), ring.end(), result.points.begin());
    return result;
}

SectionMeasures of(const SliceResult& result) {
    return value_of(measure(result, {.feret = true})).layers[0];
}

bool near(double found, double right) {
    return std::abs(found - right) <= 4e-16 * std::abs(right);
}

/// Area, centroid, ix, iy and ixy about it, imin, perimeter, squares of the largest and the smallest diameter.
struct Shape {
    const char* name;
    Rings rings;
    std::array<double, 10> measures;
};

const double root193 = std::sqrt(193);
const double root9945 = std::sqrt(9945);
const double root13 = std::sqrt(13);
constexpr std::int32_t far_away = (1 << 30) - 1000;

const Ring letter_l = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}};
const Ring letter_u = {{0, 0}, {5, 0}, {5, 4}, {4, 4}, {4, 1}, {1, 1}, {1, 4}, {0, 4}};
const Ring plus = {{1, 0}, {2, 0}, {2, 1}, {3, 1}, {3, 2}, {2, 2}, {2, 3}, {1, 3}, {1, 2}, {0, 2}, {0, 1}, {1, 1}};
const Ring in_annulus = {{0, -5}, {-3, -4}, {-4, -3}, {-5, 0}, {-4, 3}, {-3, 4},
                         {0, 5},  {3, 4},   {4, 3},   {5, 0},  {4, -3}, {3, -4}};
const Ring annulus = {{10, 0},  {8, 6},   {6, 8},   {0, 10},  {-6, 8}, {-8, 6},
                      {-10, 0}, {-8, -6}, {-6, -8}, {0, -10}, {6, -8}, {8, -6}};
const Rings island_in_hole = {box(-5, -5, 5, 5), reversed(box(-3, -3, 3, 3)), box(-1, -1, 1, 1)};

const std::vector<Shape> shapes_known = {
    {"rectangle", {box(10, 20, 14, 22)}, {8, 12, 21, 8 / 3., 32 / 3., 0, 8 / 3., 12, 20, 4}},
    {"square", {box(0, 0, 6, 6)}, {36, 3, 3, 108, 108, 0, 108, 24, 72, 36}},
    {"triangle", {{{0, 0}, {3, 0}, {0, 4}}}, {6, 1, 4 / 3., 16 / 3., 3, -2, 25 / 6. - root193 / 6, 12, 25, 144 / 25.}},
    {"L", {letter_l}, {6, 1.5, 1, 4, 8.5, -3, 2.5, 14, 25, 9}},
    {"U", {letter_u}, {11, 2.5, 35 / 22., 2089 / 132., 419 / 12., 0, 2089 / 132., 24, 41, 16}},
    {"dart", {{{0, 0}, {4, -3}, {2, 0}, {4, 3}}}, {6, 2, 0, 9, 4, 0, 4, 10 + 2 * root13, 36, 16}},
    {"parallelogram",
     {{{0, 0}, {6, 0}, {8, 3}, {2, 3}}},
     {18, 4, 1.5, 13.5, 60, 9, 147 / 4. - root9945 / 4, 12 + 2 * root13, 73, 9}},
    {"plus", {plus}, {5, 1.5, 1.5, 29 / 12., 29 / 12., 0, 29 / 12., 12, 10, 8}},
    {"hole in the middle", {box(0, 0, 4, 4), reversed(box(1, 1, 3, 3))}, {12, 2, 2, 20, 20, 0, 20, 24, 32, 16}},
    {"hole aside",
     {box(0, 0, 6, 6), reversed(box(1, 1, 3, 3))},
     {32, 25 / 8., 25 / 8., 613 / 6., 613 / 6., -4.5, 293 / 3., 32, 72, 36}},
    {"turned rectangle",
     {{{0, 0}, {8, 6}, {5, 10}, {-3, 4}}},
     {50, 2.5, 5, 650 / 3., 1825 / 6., 150, 625 / 6., 30, 125, 25}},
    {"annulus", {annulus, in_annulus}, {222, 0, 0, 6545, 6545, 0, 6545, 24 * std::sqrt(10) + 12 * std::sqrt(2), 400, 360}},
    {"two squares", {box(0, 0, 2, 2), box(10, 0, 12, 2)}, {8, 6, 1, 8 / 3., 608 / 3., 0, 8 / 3., 16, 148, 4}},
    {"island in a hole", island_in_hole, {68, 0, 0, 2180 / 3., 2180 / 3., 0, 2180 / 3., 72, 200, 100}},
    {"needle",
     {{{0, 0}, {1000, 1000}, {999, 1001}, {-1, 1}}},
     {2000, 499.5, 500.5, 500000500 / 3., 500000500 / 3., 166666500, 1000 / 3., 2002 * std::sqrt(2), 2000002, 2}},
    {"square at the grid's end",
     {box(far_away, far_away, far_away + 1000, far_away + 1000)},
     {1e6, 1073741324, 1073741324, 25e10 / 3, 25e10 / 3, 0, 25e10 / 3, 4000, 2e6, 1e6}},
};

/// Cells of a random pattern on a lattice, of which some touch in corners, and what they measure, summed cell by cell.
struct Cells {
    static constexpr std::int32_t side = 12;
    Rings rings;
    double area = 0;
    std::array<double, 5> sums{};  // x, y, xx, yy, xy

    explicit Cells(std::mt19937& random, std::int32_t scale) {
        const Point at = {polygons::below(random, 1000), polygons::below(random, 1000)};
        const unsigned share = 2 + unsigned(random() % 6);
        for (std::int32_t i = 0; i < side * side; ++i) {
            if (random() % 8 < share) {
                const std::int32_t x = at.x + i % side;
                const std::int32_t y = at.y + i / side;
                rings.push_back(box(scale * x, scale * y, scale * (x + 1), scale * (y + 1)));
                const double s = scale;
                area += s * s;
                const double cx = s * (x + 0.5);
                const double cy = s * (y + 0.5);
                const double own = s * s * s * s / 12;
                const std::array<double, 5> all = {s * s * cx, s * s * cy, s * s * cx * cx + own, s * s * cy * cy + own,
                                                   s * s * cx * cy};
                for (std::size_t n = 0; n < all.size(); ++n) {
                    sums[n] += all[n];
                }
            }
        }
    }
};

double distance(Point a, Point b) {
    return std::hypot(double(a.x) - b.x, double(a.y) - b.y);
}

/// Of all pairs of points, and of all lines through two with every point on one side.
std::array<double, 2> feret_of_pairs(std::span<const Point> points) {
    double most = 0;
    double least = std::numeric_limits<double>::infinity();
    for (const Point a : points) {
        for (const Point b : points) {
            if (a != b) {
                double low = 0;
                double high = 0;
                for (const Point c : points) {
                    const double area =
                        (double(b.x) - a.x) * (double(c.y) - a.y) - (double(b.y) - a.y) * (double(c.x) - a.x);
                    low = std::min(low, area / distance(a, b));
                    high = std::max(high, area / distance(a, b));
                }
                least = std::min(least, low == 0 || high == 0 ? high - low : least);
                most = std::max(most, distance(a, b));
            }
        }
    }
    return {most, least};
}

}  // namespace

TEST_CASE("shapes have the measures that are known of them", "[measures]") {
    for (const Shape& shape : shapes_known) {
        INFO(shape.name);
        const SectionMeasures found = of(region(shape.rings));
        const auto& [area, x, y, ix, iy, ixy, imin, perimeter, feret_max, feret_min] = shape.measures;
        CHECK(found.area_mm2 == area);
        CHECK((near(found.centroid_mm[0], x) && near(found.centroid_mm[1], y)));
        CHECK((near(found.ix_mm4, ix) && near(found.iy_mm4, iy) && near(found.ixy_mm4, ixy)));
        CHECK((near(found.imin_mm4, imin) && near(found.imax_mm4, ix + iy - imin) && near(found.polar_mm4, ix + iy)));
        const bool all_alike = ix == iy && ixy == 0;
        CHECK(std::isnan(found.angle_rad) == all_alike);
        CHECK((all_alike || std::abs(found.angle_rad - std::atan2(2 * ixy, iy - ix) / 2) < 1e-15));
        CHECK(std::abs(found.perimeter_mm - perimeter) < 1e-15 * perimeter);
        CHECK((near(found.feret_max_mm, std::sqrt(feret_max)) && near(found.feret_min_mm, std::sqrt(feret_min))));
        CHECK(near(found.equivalent_diameter_mm, std::sqrt(4 * area / std::numbers::pi)));
    }
    CHECK(near(of(region(shapes_known[1].rings)).circularity, std::numbers::pi / 4));
    CHECK(near(of(region(shapes_known[12].rings)).circularity, std::numbers::pi / 8));
    CHECK(near(of(region(shapes_known[13].rings)).circularity, std::numbers::pi * 4 * 104 / (48 * 48)));
    CHECK(near(of(region({box(0, 0, 3, 4)})).feret_angle_rad, -std::atan2(4, 3)));
}

TEST_CASE("islands count for themselves, those in holes too, and add up to the layer", "[measures]") {
    const SliceResult result = region(shapes_known[13].rings);
    const Measures found = value_of(measure(result, {.islands = true, .feret = true}));
    REQUIRE(found.islands.size() == 2);
    CHECK(found.layers[0].islands == 2);
    CHECK(found.layers[0].holes == 1);
    CHECK(found.layers[0].outer_area_mm2 == 104);
    for (const SectionMeasures& island : found.islands) {
        const bool inner = island.holes == 0;
        CHECK(result.contours[std::size_t(island.contour)].role == Role::outer);
        CHECK(island.area_mm2 == (inner ? 4 : 64));
        CHECK(island.box_max_mm[0] == (inner ? 1 : 5));
        CHECK(near(island.feret_min_mm, inner ? 2 : 10));
        CHECK(near(island.polar_mm4, inner ? 8 / 3. : (10000 - 1296) / 6.));
    }
}

TEST_CASE("random lattices measure what their cells sum up to, as large as the grid allows", "[measures]") {
    std::mt19937 random(1);
    for (int i = 0; i < 200; ++i) {
        const Cells cells(random, i % 2 == 0 ? 1 : 1'000'000);
        const SliceResult result = region(cells.rings);
        const SectionMeasures found = of(result);
        REQUIRE(found.area_mm2 == cells.area);
        const auto& [x, y, xx, yy, xy] = cells.sums;
        const double scale = xx + yy;  // about the origin: what doubles lose
        CHECK(std::abs(found.centroid_mm[0] - x / cells.area) < 1e-13 * x / cells.area);
        CHECK(std::abs(found.iy_mm4 - (xx - x * x / cells.area)) < 1e-13 * scale);
        CHECK(std::abs(found.ix_mm4 - (yy - y * y / cells.area)) < 1e-13 * scale);
        CHECK(std::abs(found.ixy_mm4 - (xy - x * y / cells.area)) < 1e-13 * scale);
        CHECK(near(found.polar_mm4, found.imin_mm4 + found.imax_mm4));
        if (i % 16 < 2) {  // of all pairs and all points: a tenth of a second
            const auto [most, least] = feret_of_pairs(result.points.span());
            CHECK(std::abs(found.feret_max_mm - most) < 1e-15 * most);
            CHECK(std::abs(found.feret_min_mm - least) < 4e-15 * most);
        }
    }
}

TEST_CASE("diameters of points in any position are those of all pairs", "[measures]") {
    std::mt19937 random(2);
    for (int i = 0; i < 300; ++i) {
        const std::int32_t size = std::array{3, 20, 1'000'000'000}[std::size_t(i % 3)];
        Ring ring;
        for (int n = 0; n < 3 + i % 40; ++n) {
            ring.push_back({polygons::below(random, size) - size / 2, polygons::below(random, size) - size / 2});
        }
        const SectionMeasures found = of(as_walked(ring));
        const auto [most, least] = feret_of_pairs(ring);
        CHECK(std::abs(found.feret_max_mm - most) <= 1e-15 * most);
        CHECK((std::isinf(least) ? found.feret_min_mm == 0 : std::abs(found.feret_min_mm - least) <= 1e-14 * most));
    }
}

TEST_CASE("what is not known is NaN, what is empty 0", "[measures]") {
    const SliceResult open = sliced(shapes::without(shapes::box({0, 0, 0}, {4, 4, 4}), 4, 1), at_heights({2}));
    const SectionMeasures unknown = of(open);
    CHECK((!unknown.known && unknown.open == 1));
    for (const double number : {unknown.area_mm2, unknown.perimeter_mm, unknown.ix_mm4, unknown.imin_mm4, unknown.polar_mm4,
                                unknown.box_min_mm[0], unknown.feret_max_mm, unknown.equivalent_diameter_mm}) {
        CHECK(std::isnan(number));
    }
    const SectionMeasures empty = of(sliced(shapes::box({0, 0, 0}, {4, 4, 4}), at_heights({9})));
    CHECK((empty.known && empty.islands == 0 && empty.area_mm2 == 0 && empty.ix_mm4 == 0 &&
           empty.equivalent_diameter_mm == 0));
    CHECK((std::isnan(empty.centroid_mm[0]) && std::isnan(empty.circularity) && std::isnan(empty.feret_min_mm)));

    const Ring bow = {{0, 0}, {2, 2}, {2, 0}, {0, 2}};
    const SectionMeasures walked = of(as_walked(bow));
    CHECK((walked.area_mm2 == 0 && std::isnan(walked.centroid_mm[0]) && std::isnan(walked.ix_mm4)));
    const Measures parted = value_of(measure(region({bow}, FillRule::non_zero), {.islands = true}));
    CHECK((parted.layers[0].area_mm2 == 2 && parted.islands.size() == 2));
}

TEST_CASE("a contour that winds around the whole grid is summed, and refused where sums leave 128 bits", "[measures]") {
    const Ring whole = box(-grid_limit, -grid_limit, grid_limit, grid_limit);
    Ring wound;
    for (int turns = 1; turns <= 4; ++turns) {
        wound.insert(wound.end(), whole.begin(), whole.end());
        Result<Measures> found = measure(as_walked(wound));
        INFO(turns << " turns");
        if (turns < 4) {
            REQUIRE(found.ok());
            CHECK(near(found->layers[0].ix_mm4, turns * std::pow(2, 124) / 12));
        } else {
            REQUIRE(!found);
            CHECK(found.error().message.find("layer 0: its contours wind around so much") == 0);
        }
    }
    CHECK(code_of(measure(as_walked(box(0, 0, grid_limit + 1, 4)))) == ErrorCode::invalid_argument);
}

TEST_CASE("measures have the same bytes on any number of threads, and of a layer by itself", "[measures]") {
    const SliceResult result = sliced(shapes::octasphere({0.3, 0.1, 5}, 5, 4), uniform(0.05));
    const Measures all = value_of(measure(result, {.islands = true, .feret = true}));
    std::uint64_t hash = 14695981039346656037U;
    for (const int threads : {1, 2, 7}) {
        const Measures again = value_of(measure(result, {.islands = true, .feret = true}, {.threads = threads}));
        CHECK(std::memcmp(again.layers.data(), all.layers.data(), all.layers.size() * sizeof(SectionMeasures)) == 0);
        CHECK(std::memcmp(again.islands.data(), all.islands.data(), all.islands.size() * sizeof(SectionMeasures)) == 0);
    }
    for (std::size_t i = 0; i < result.size(); ++i) {
        const SectionMeasures alone = value_of(measure(result[i], {.feret = true})).layers[0];
        REQUIRE(std::memcmp(&alone, &all.layers[i], sizeof alone) == 0);
        for (const double number :
             {alone.ix_mm4, alone.imin_mm4, alone.angle_rad, alone.feret_angle_rad, alone.circularity}) {
            hash = (hash ^ (std::isnan(number) ? 0 : bits_as<std::uint64_t>(number))) * 1099511628211U;
        }
    }
    CHECK(hash == 0x72fca757a75031d0);  // on every platform
}

TEST_CASE("a C program gets the same rows, in arrays of its own", "[measures]") {
    const lamella_result held{sliced(shapes::octasphere({0, 0, 5}, 5, 2), uniform(0.5))};
    const Measures right = value_of(measure(held.result, {.islands = true, .feret = true}));
    std::vector<lamella_section_measures> layers(right.layers.size());
    std::vector<lamella_section_measures> islands(right.islands.size());
    const auto call = [&](std::size_t layer_count, std::size_t island_count) {
        return lamella_measure(&held, 1, nullptr, layers.data(), layer_count, islands.data(), island_count, nullptr);
    };
    REQUIRE(call(layers.size(), islands.size()) == LAMELLA_OK);
    CHECK(std::memcmp(layers.data(), right.layers.data(), layers.size() * sizeof layers[0]) == 0);
    CHECK(std::memcmp(islands.data(), right.islands.data(), islands.size() * sizeof islands[0]) == 0);
    CHECK(call(layers.size() - 1, islands.size()) == LAMELLA_INVALID_ARGUMENT);
    CHECK(call(layers.size(), 0) == LAMELLA_INVALID_ARGUMENT);
    CHECK(lamella_measure(nullptr, 0, nullptr, layers.data(), 0, nullptr, 0, nullptr) == LAMELLA_INVALID_ARGUMENT);
}
