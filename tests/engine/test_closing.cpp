// Closing against dilating and eroding everything, offsets with written-down answers, and marks of near contours.
#include <tuple>

#include "engine/polygons.hpp"
#include "engine/region_checks.hpp"
#include "engine/slicing.hpp"

using namespace lamella;
using namespace polygons;
using regions::RegionRules;

namespace {

using Lines = std::vector<std::string>;

constexpr double unit_mm = default_grid_mm;

SliceResult region_by(const Rings& rings, const RegionRules& rules) {
    auto made = value_of(regions::region(rings, rules));
    CHECK(regions::broken_promise(made) == "");
    const auto again = value_of(regions::region(regions::shuffled(rings, 77), rules));
    CHECK(regions::same(made, again));
    return made;
}

RegionRules rules_by(double close_units, double offset_units = 0, double miter_limit = 3) {
    return {.fill_rule = FillRule::non_zero,
            .closing_mm = close_units * unit_mm,
            .offset_mm = offset_units * unit_mm,
            .miter_limit = miter_limit};
}

/// Closes, and compares with closing everything.
SliceResult closed(const Rings& rings, double radius_units, double miter_limit = 3) {
    const RegionRules rules = rules_by(radius_units, 0, miter_limit);
    SliceResult made = region_by(rings, rules);
    const auto everywhere = value_of(regions::closed_everywhere(rings, rules));
    const double difference = regions::difference_of(made, everywhere);
    const double perimeter = regions::perimeter_of(regions::rings_of(region_by(rings, rules_by(0))));
    INFO("a difference of " << difference << " square units along " << perimeter << " units");
    CHECK(difference >= 0);
    CHECK(difference * unit_mm <= 5e-6 * perimeter);
    return made;
}

/// True for each contour that is marked.
std::vector<bool> marks_of(const Rings& rings, double radius_units, double miter_limit = 3) {
    RegionRules rules = rules_by(0, 0, miter_limit);
    rules.flag_closing_mm = radius_units * unit_mm;
    const SliceResult marked = region_by(rings, rules);
    std::vector<bool> marks;
    for (const Contour& contour : marked.contours) {
        marks.push_back((contour.flags & would_close) != 0);
    }
    return marks;
}

constexpr double radius = 51'380;  // 0.049 mm

TEST_CASE("gaps under twice the radius are closed, others stay", "[closing]") {
    const int r = GENERATE(1, 2, 7, 1000, 51'380);
    const double limit = GENERATE(1.0, 1.2, 3.0, 10.0);
    const int over = GENERATE(-2, -1, 0, 1, 2);
    CAPTURE(r, limit, over);
    const int gap = 2 * r + over;
    const Rings pair = {box(0, 0, 100 * r, 50 * r), box(100 * r + gap, 0, 200 * r + gap, 50 * r)};
    const SliceResult made = closed(pair, r, limit);
    // At twice the radius exactly the dilated ones have a line in common.
    CHECK(made.contours.size() == (over <= 0 ? 1 : 2));
    const Rings slot = {box(0, 0, 100 * r, 100 * r), reversed(box(20 * r, 20 * r, 80 * r, 20 * r + gap))};
    CHECK(closed(slot, r, limit).contours.size() == (over <= 0 ? 1 : 2));
    const Rings rings = {box(0, 0, 100 * r, 100 * r), reversed(box(10 * r, 10 * r, 90 * r, 90 * r)),
                         box(10 * r + gap, 10 * r + gap, 90 * r - gap, 90 * r - gap)};
    const SliceResult ringed = closed(rings, r, limit);
    if (limit >= 3) {  // below, the cut corners of the inner one leave holes
        CHECK(ringed.contours.size() == (over <= 0 ? 1 : 3));
    }
}

TEST_CASE("closing agrees with closing everything on random polygons", "[closing]") {
    const unsigned seed = GENERATE(range(1U, 1 + rounds(120)));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const double limit = std::array{1.0, 1.2, 3.0, 10.0}[random() % 4];
    const double r = std::array{2'000.0, 51'380.0, 300'000.0}[random() % 3];
    closed({star(random, 40, 400'000, 4'000'000)}, r, limit);
    closed(lattice_boxes(random, 30, 40, static_cast<int>(r)), r, limit);
    closed(lattice_points(random, 4, 8, 9, static_cast<int>(3 * r)), r, limit);
    // Notches with edges shorter than the radius, beside one that comes near, and as a hole around a body.
    const double size = r * std::pow(10, between(random, 0.3, 2));
    const Ring slab = ragged(random, size);
    closed({slab, round({0, rounded(-2.1 * size)}, size, 50)}, r, limit);
    closed({box(-9 * int(size), -9 * int(size), 9 * int(size), 9 * int(size)), reversed(slab),
            round({0, rounded(4 * size)}, size, 50)},
           r, limit);
}

TEST_CASE("closing agrees with closing everything where folding and rounding are delicate", "[closing]") {
    // A wall of a notch runs from its floor to a sharp corner. Dilated, that is cut: the edge along the cut bounds what is
    // dilated, and not the lines of the edges on both sides of the wall.
    closed({{{0, 200'000}, {60'000, 60'000}, {160'000, 20'000}, {190'000, 180'000}, {80'000, 190'000}, {160'000, 130'000}}},
           20'000);
    closed(
        {{{140'000, 180'000}, {180'000, 20'000}, {10'000, 40'000}, {70'000, 100'000}, {70'000, 90'000}, {100'000, 40'000}}},
        50'000, 1.2);
    // Without one wall of the slit at -422165,1578876 the other would be a unit long: its direction, rounded, is any. Other
    // contours touch the slit's mouth, so that what it is dilated to is eroded again.
    closed({{{-2'489'867, 409'499}, {0, 0}, {-592'670, 1'482'448}},
            {{-653'498, 1'634'598},
             {-592'670, 1'482'448},
             {-422'165, 1'578'876},
             {-490'590, 1'834'783},
             {-404'805, 1'588'693},
             {0, 1'817'628},
             {0, 2'437'636}},
            {{-422'165, 1'578'876}, {0, 0}, {0, 427'428}, {-404'805, 1'588'693}},
            {{0, 0}, {148'997, 0}, {41'210, 309'207}},
            {{0, 427'428}, {41'210, 309'207}, {261'997, 1'965'799}, {0, 1'817'628}}},
           81'921, 10);
    // A folded corner falls on the point beside it.
    closed({{{9, -22}, {14, -21}, {28, -22}, {40, -23}, {52, -24}, {52, -22}, {40, -21}, {28, -22}, {14, -19}, {9, -21}},
            {{-19, -7}, {-19, 34}, {-10, 34}, {-10, -7}},
            {{-36, 0},
             {-32, -24},
             {-31, -10},
             {26, 30},
             {32, 32},
             {-27, -28},
             {26, -7},
             {-21, 32},
             {51, -43},
             {-19, -43},
             {37, -43},
             {-7, 22}}},
           3);
    // Folded, some edges are so short that their directions, rounded, are any.
    closed({{{41309, 7276},    {63135, 14699},   {68404, 29840},   {33107, 24203},   {16492, 17819},   {16068, 28997},
             {34681, 84101},   {6823, 43357},    {-1053, 80070},   {-22744, 84703},  {-10262, 21402},  {-38698, 57159},
             {-65262, 54184},  {-41424, 19255},  {-64822, 23265},  {-63073, 9685},   {-24435, -182},   {-76903, -29838},
             {-59379, -29147}, {-56049, -44669}, {-59315, -67842}, {-44255, -73638}, {-16714, -49388}, {-3231, -22021},
             {7544, -51276},   {32514, -86045},  {13090, -22455},  {25888, -26820},  {63938, -43950},  {48405, -22697},
             {78379, -22255},  {86177, -16702}}},
           97'499, 10);
}

TEST_CASE("closing loses nothing between edges that are bent onto one another", "[closing][regions]") {
    const shapes::Soup walls = shapes::joined(
        {shapes::walls({{2, 24}, {0, 34}, {-4, 34}, {-6, 32}, {-12, 22}, {-10, 18}, {-8, 20}, {-4, 18}, {4, 20}}),
         shapes::walls({{-6, 20}, {-2, 20}, {-8, 14}, {-12, 14}, {-16, 12}, {-22, 22}, {-20, 30}, {-20, 28}, {-8, 28}})});
    SliceOptions options{.heights_mm = {{5.5}}, .frame = {.grid_mm = 1}, .region = {.fill_rule = FillRule::positive}};
    const auto area = [&] { return regions::area_of(sliced(walls, options)); };
    const double open = area();
    options.region.closing_mm = 9;
    options.region.miter_limit = 4;
    CHECK(area() >= open);
}

TEST_CASE("a contour with nothing near is the same contour after closing", "[closing]") {
    const Rings far = {round({0, 0}, 1'000'000, 40), reversed(round({0, 0}, 400'000, 30)),
                       round({5'000'000, 0}, 1'000'000, 40)};
    CHECK(regions::same(region_by(far, rules_by(radius)), region_by(far, rules_by(0))));
}

TEST_CASE("offsets of squares can be written down", "[closing]") {
    const Ring square = box(0, 0, 1000, 1000);
    const Rings frame = {square, reversed(box(400, 400, 600, 600))};
    RegionRules merged = rules_by(0, 10);
    merged.drop_collinear = true;
    RegionRules positive = rules_by(5.25, 0, 1);
    positive.fill_rule = FillRule::positive;
    const Ring hook = {{-46, -93}, {-52, -93}, {-52, -80},  {-92, -80},  {-92, -63},
                       {-39, -63}, {-39, -68}, {-100, -68}, {-100, -100}};
    const std::tuple<Rings, RegionRules, Lines> cases[] = {
        {{square}, rules_by(0, 10), {"outer + x4 in -: -10,-10 1010,-10 1010,1010 -10,1010"}},
        {{square}, rules_by(0, -10), {"outer + x4 in -: 10,10 990,10 990,990 10,990"}},
        {{square}, rules_by(0, -499), {"outer + x4 in -: 499,499 501,499 501,501 499,501"}},
        {{square}, rules_by(0, -500), {}},
        {{square}, rules_by(0, -2000), {}},
        {frame,
         rules_by(0, 10),
         {"outer + x4 in -: -10,-10 1010,-10 1010,1010 -10,1010", "hole - x4 in 0: 410,410 410,590 590,590 590,410"}},
        {frame, rules_by(0, 100), {"outer + x4 in -: -100,-100 1100,-100 1100,1100 -100,1100"}},
        {frame,
         rules_by(0, -150),
         {"outer + x4 in -: 150,150 850,150 850,850 150,850", "hole - x4 in 0: 250,250 250,750 750,750 750,250"}},
        {frame, rules_by(0, -200), {}},
        {{square, box(1015, 0, 2000, 1000)}, merged, {"outer + x4 in -: -10,-10 2010,-10 2010,1010 -10,1010"}},
        {{square, box(1021, 0, 2000, 1000)},
         merged,
         {"outer + x4 in -: -10,-10 1010,-10 1010,1010 -10,1010", "outer + x4 in -: 1011,-10 2010,-10 2010,1010 1011,1010"}},
        // Over the limit a corner is cut across its bisector, at the offset's distance.
        {{square},
         rules_by(0, 10, 1),
         {"outer + x8 in -: -10,-4 -4,-10 1004,-10 1010,-4 1010,1004 1004,1010 -4,1010 -10,1004"}},
        {{hook},
         positive,
         {"outer + x9 in -: -100,-100 -46,-93 -49,-93 -52,-90 -52,-80 -89,-80 -92,-77 -92,-68 "
          "-100,-68"}}};  // rounding lays edges of the needle on each other
    for (const auto& [rings, rules, expected] : cases) {
        CHECK(contours_at(region_by(rings, rules), 0) == expected);
    }
}

TEST_CASE("exactly the contours that closing changes or joins are marked", "[closing]") {
    const int over = GENERATE(-2, -1, 0, 10);
    const int gap = 200 + over;
    CAPTURE(over);
    const bool near = over <= 0;
    // Two that come near each other, one far away, and one that comes near itself.
    const Rings row = {box(0, 0, 1000, 1000),
                       box(1000 + gap, 0, 3000, 1000),
                       box(5000, 0, 6000, 1000),
                       {{8000, 0},
                        {9000, 0},
                        {9000, 1000},
                        {8500 + gap, 1000},
                        {8500 + gap, 300},
                        {8500, 300},
                        {8500, 1000},
                        {8000, 1000}}};
    CHECK(marks_of(row, 100) == std::vector<bool>{near, near, false, near});
}

TEST_CASE("a body that closing swallows is marked though no dilated curves meet", "[closing]") {
    // The hole is 10 wide and the body in it 1: dilated by 4 they are 2 and 9 wide.
    const Rings rings = {box(0, 0, 3000, 3000), reversed(box(1000, 1000, 2000, 2000)), box(1450, 1450, 1550, 1550),
                         box(9000, 0, 9900, 900)};
    CHECK(marks_of(rings, 400) == std::vector<bool>{false, true, true, false});
    CHECK(marks_of(rings, 200) == std::vector<bool>{false, false, false, false});
    CHECK(contours_at(region_by(rings, rules_by(400)), 0) ==
          Lines{"outer + x4 in -: 0,0 3000,0 3000,3000 0,3000", "outer + x4 in -: 9000,0 9900,0 9900,900 9000,900"});
}

TEST_CASE("marked contours are those that closing changes, on random layers", "[closing]") {
    const unsigned seed = GENERATE(range(1U, 1 + rounds(60)));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const Rings rings = regions::rings_of(region_by(lattice_boxes(random, 12, 40, 1000), rules_by(0)));
    const auto marks = marks_of(rings, 700);
    const Rings after = regions::rings_of(region_by(rings, rules_by(700)));
    REQUIRE(marks.size() == rings.size());
    for (std::size_t c = 0; c < rings.size(); ++c) {
        CAPTURE(c);
        const bool kept = std::find(after.begin(), after.end(), rings[c]) != after.end();
        CHECK((kept || marks[c]));
    }
    const bool any = std::find(marks.begin(), marks.end(), true) != marks.end();
    CHECK((any || after == rings));
}

TEST_CASE("closing and offsets that lead beyond the grid are refused", "[closing]") {
    constexpr std::int32_t end = grid_limit;
    RegionRules mark = rules_by(0);
    mark.flag_closing_mm = 10 * unit_mm;
    for (const RegionRules& rules : {rules_by(10), rules_by(0, 1), mark}) {
        const Error error = error_of(regions::region({box(-end, -end, end, end)}, rules));
        CHECK(error.code == ErrorCode::invalid_argument);
        CHECK_THAT(error.message, Catch::Contains("beyond the grid"));
    }
    // Dilated, both meet at their feet in an acute notch. Its miter on the way back leads farther down than the first
    // estimate reckons with.
    const auto feet = [](std::int32_t bottom) {
        const std::int32_t top = bottom + 100'000;
        return Rings{{{-200'000, bottom}, {0, bottom}, {-10'510, top}, {-200'000, top}},
                     {{2'200, bottom}, {200'000, bottom}, {200'000, top}, {12'710, top}}};
    };
    const Error error = error_of(regions::region(feet(-end + 10'000), rules_by(1000, 0, 10)));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK_THAT(error.message, Catch::Contains("beyond the grid, which ends at 1073741824 units"));
    CHECK(closed(feet(-end + 11'000), 1000, 10).contours.size() == 2);
}

TEST_CASE("each layer has the rule that it is given", "[closing]") {
    // A box within a box, both upright: two windings inside.
    const shapes::Soup soup = shapes::joined({shapes::box({0, 0, 0}, {10, 10, 10}), shapes::box({2, 2, 0}, {8, 8, 10})});
    const RegionRules rules{.fill_rule = FillRule::non_zero,
                            .fill_from = {{1, FillRule::even_odd}, {3, FillRule::contours}, {4, FillRule::outermost}}};
    const SliceResult result = sliced(soup, {.heights_mm = {{1, 3, 5, 7, 9}}, .region = rules});
    std::vector<double> areas;
    std::vector<std::uint64_t> counts;
    for (const LayerView layer : result) {
        areas.push_back(layer.area_mm2());
        counts.push_back(layer.contour_count);
    }
    CHECK(areas == std::vector<double>{100, 64, 64, areas[3], 100});
    CHECK(counts == std::vector<std::uint64_t>{1, 2, 2, 2, 1});
}

TEST_CASE("contours over the whole grid cross in the right places", "[closing]") {
    constexpr std::int32_t end = grid_limit;
    const Ring square = box(-end, -end, end, end);
    const Ring diamond = {{-end, 0}, {0, -end}, {end, 0}, {0, end}};
    const double whole = 4.0 * end * end;
    CHECK(regions::area_of(region_by({square}, rules_by(0))) == whole);
    CHECK(regions::area_of(region_by({square, diamond}, rules_by(0))) == whole);
    RegionRules odd = rules_by(0);
    odd.fill_rule = FillRule::even_odd;
    CHECK(regions::area_of(region_by({square, diamond}, odd)) == whole / 2);
    // Both diagonals in one contour: a bow tie, whose halves run opposite ways.
    const Ring bow = {{-end, -end}, {end, end}, {end, -end}, {-end, end}};
    CHECK(contours_at(region_by({bow}, odd), 0) ==
          Lines{"outer + x3 in -: -1073741824,-1073741824 0,0 -1073741824,1073741824",
                "outer + x3 in -: 0,0 1073741824,-1073741824 1073741824,1073741824"});
    RegionRules positive = odd;
    positive.fill_rule = FillRule::positive;
    CHECK(regions::area_of(region_by({bow}, positive)) == whole / 4);
    std::mt19937 random(3);
    for (int i = 0; i < 20; ++i) {
        const Rings rings = lattice_points(random, 6, 12, 5, 1 << 29);
        region_by(rings, odd);
        region_by(rings, positive);
    }
}

}  // namespace
