// Regions by each fill rule, compared with written-down answers and with the winding numbers of random places; and which
// rules are refused, by which words.
#include <array>
#include <limits>
#include <tuple>

#include "engine/polygons.hpp"
#include "engine/slicing.hpp"
#include "regions/region.hpp"

using namespace lamella;
using namespace polygons;
using Catch::Contains;

namespace {

constexpr FillRule all_rules[] = {FillRule::contours, FillRule::even_odd, FillRule::non_zero, FillRule::positive};

/// What a rule leaves of a layer: outer contours, holes, and the area in square millimetres, -1 where it is not known.
using Outcome = std::array<double, 3>;
using Outcomes = std::vector<Outcome>;

/// Slices at mid-height solids that extend from z = 0 to 10.
SliceResult filled(const shapes::Soup& soup, FillRule rule) {
    SliceResult result =
        sliced(soup, {.heights_mm = {{5}}, .frame = {.grid_mm = coarse_unit_mm}, .region = {.fill_rule = rule}});
    CHECK(result.info.options.region.fill_rule == rule);
    return result;
}

Outcome outcome_of(const SliceResult& result) {
    const auto count = [&](Role role) {
        return static_cast<double>(std::count_if(result.contours.begin(), result.contours.end(),
                                                 [role](const Contour& contour) { return contour.role == role; }));
    };
    const double area = result[0].area_mm2();
    return {count(Role::outer), count(Role::hole), std::isnan(area) ? -1 : area};
}

/// A prism over a square; inside out where the size is negative.
struct Square {
    double x;
    double y;
    double size;
};

shapes::Soup solids(const std::vector<Square>& squares) {
    shapes::Soup soup;
    for (const auto& [x, y, size] : squares) {
        const double side = std::abs(size);
        const shapes::Soup prism = shapes::box({x, y, 0}, {x + side, y + side, 10});
        shapes::append(soup, size < 0 ? shapes::flipped(prism) : prism);
    }
    return soup;
}

TEST_CASE("fill rules: what becomes of solids that overlap, touch, lie in each other or are inverted", "[engine][fill]") {
    struct Case {
        const char* name;
        std::vector<Square> squares;
        Outcomes expected;       ///< by contours, even-odd, non-zero and positive
        bool cancelled = false;  ///< by non-zero shells turned inwards take solid away
    };
    // Three shells around two overlapping squares. The overlap then has winding number 5. By even-odd it touches the solid
    // around it in two points, and the hole between them passes both points twice. Three inverted shells more make the
    // winding number around the pair zero, and a fourth makes it negative.
    const std::vector<Square> shells = {{-30, -30, 80}, {-20, -20, 60}, {-10, -10, 40}};
    const std::vector<Square> pair = {{0, 0, 10}, {5, 5, 10}};
    const std::vector<Square> undone = {{-5, -5, -30}, {-4, -4, -28}, {-3, -3, -26}};
    const auto within = [&](std::vector<Square> around, const std::vector<Square>& more) {
        around.insert(around.begin(), shells.begin(), shells.end());
        around.insert(around.end(), more.begin(), more.end());
        return around;
    };
    std::vector<Square> thousand(1000, {0, 0, 10});
    thousand.push_back({5, 5, 10});
    std::vector<Square> below = undone;
    below.push_back({-2, -2, -24});
    const Case cases[] = {
        {"one", {{0, 0, 10}}, Outcomes(4, {1, 0, 100})},
        {"two that overlap", pair, {{2, 0, 200}, {2, 0, 150}, {1, 0, 175}, {1, 0, 175}}},
        {"coplanar sides", {{0, 0, 10}, {5, 0, 10}}, {{2, 0, 200}, {2, 0, 100}, {1, 0, 150}, {1, 0, 150}}},
        {"a common side", {{0, 0, 10}, {10, 0, 10}}, {{2, 0, 200}, {1, 0, 200}, {1, 0, 200}, {1, 0, 200}}},
        {"an insert", {{0, 0, 30}, {10, 10, 10}}, {{2, 0, 1000}, {1, 1, 800}, {1, 0, 900}, {1, 0, 900}}},
        {"a cavity", {{0, 0, 30}, {10, 10, -10}}, Outcomes(4, {1, 1, 800})},
        {"exported twice", {{0, 0, 10}, {0, 0, 10}}, {{2, 0, 200}, {}, {1, 0, 100}, {1, 0, 100}}},
        {"inverted", {{0, 0, -10}}, {{1, 0, 100}, {1, 0, 100}, {1, 0, 100}, {}}},
        {"inverted across another", {{0, 0, 10}, {5, 5, -10}}, {{1, 1, 0}, {2, 0, 150}, {2, 0, 150}, {1, 0, 75}}, true},
        {"inverted on another", {{0, 0, 10}, {0, 0, -10}}, {{2, 0, 200}, {}, {}, {}}, true},
        {"inverted across one exported twice",
         {{0, 0, 10}, {0, 0, 10}, {5, 5, -10}},
         {{2, 1, 100}, {1, 0, 100}, {1, 0, 175}, {1, 0, 100}},
         true},
        {"exported twice and overlapping",
         {{0, 0, 10}, {0, 0, 10}, {5, 5, 10}},
         {{3, 0, 300}, {1, 0, 100}, {1, 0, 175}, {1, 0, 175}}},
        {"exported a thousand times", thousand, {{1001, 0, 100'100}, {1, 0, 100}, {1, 0, 175}, {1, 0, 175}}},
        {"a pocket at a face", {{0, 0, 10}, {0, 2, -4}}, {{2, 0, 116}, {1, 0, 84}, {1, 0, 84}, {1, 0, 84}}},
        {"inverted apart", {{0, 0, 10}, {20, 0, -10}}, {{2, 0, 200}, {2, 0, 200}, {2, 0, 200}, {1, 0, 100}}},
        {"inside out as a whole", {{0, 0, -10}, {5, 5, -10}}, {{1, 1, 0}, {2, 0, 150}, {1, 0, 175}, {}}},
        {"shells around a pair", within({}, pair), {{5, 0, 11800}, {3, 2, 4250}, {1, 0, 6400}, {1, 0, 6400}}},
        {"the pair where shells cancel",
         within(undone, pair),
         {{5, 3, 9440}, {5, 3, 3758}, {2, 1, 6400 - 26 * 26 + 175}, {2, 1, 6400 - 26 * 26 + 175}}},
        {"the pair below zero",
         within(below, pair),
         {{5, 4, 9816}, {5, 4, 4034}, {3, 2, 6150}, {2, 1, 6400 - 26 * 26 + 25}}},
    };
    for (const Case& one : cases) {
        for (std::size_t r = 0; r < 4; ++r) {
            INFO(one.name << ", " << name_of(all_rules[r]));
            const SliceResult result = filled(solids(one.squares), all_rules[r]);
            CHECK(outcome_of(result) == one.expected[r]);
            CHECK(result.info.cancelled_layers == (one.cancelled && all_rules[r] == FillRule::non_zero ? 1 : 0));
        }
    }
    for (const FillRule rule : all_rules) {  // an internal wall stays an open polyline
        CHECK(outcome_of(filled(shapes::joined({solids({{0, 0, 10}}), shapes::wall({2, 5}, {8, 5})}), rule)) ==
              Outcome{1, 0, -1});
    }
}

TEST_CASE("fill rules: what is empty is joined in a point, what is solid is not, and bodies lie in the hole that they touch",
          "[engine][fill][regions]") {
    const auto square = [](std::int32_t low, std::int32_t high) { return box(low, low, high, high); };
    // The hole's boundary passes the tip, but begins elsewhere. A and B begin there, and the tip lies strictly within the
    // outermost contour alone. From B the way past the left of the tip leads to A first.
    //
    //     +---------+
    //     |   A  ---+
    //     |   |/    |
    //     |   <     |
    //     |   |\    |
    //     |   B  ---+
    //     +---------+
    const Ring around = box(-100, -100, 200, 200);
    const Ring spiked = {{0, 0}, {0, 100}, {100, 100}, {100, 60}, {50, 50}, {100, 40}, {100, 0}};
    const Ring above = {{50, 50}, {70, 90}, {60, 90}};
    const Ring below = {{50, 50}, {60, 20}, {70, 20}};
    constexpr FillRule even_odd = FillRule::even_odd;
    constexpr FillRule non_zero = FillRule::non_zero;
    const std::tuple<Rings, FillRule, std::string> cases[] = {
        {{around, spiked, above}, non_zero, "outer 4 in -, hole 7 in 0, outer 3 in 1, "},
        {{around, spiked, below}, non_zero, "outer 4 in -, hole 7 in 0, outer 3 in 1, "},
        {{around, spiked, above, below}, non_zero, "outer 4 in -, hole 7 in 0, outer 3 in 1, outer 3 in 1, "},
        {{square(0, 12), {{1, 1}, {1, 11}, {6, 11}, {6, 6}, {11, 11}, {11, 1}}, {{6, 6}, {8, 4}, {8, 6}}},
         even_odd,
         "outer 4 in -, hole 6 in 0, outer 3 in 1, "},
        {{square(0, 20), square(10, 30)}, non_zero, "outer 8 in -, "},  // the example of layers.hpp, finer
        {{square(0, 20), square(20, 40)}, non_zero, "outer 4 in -, outer 4 in -, "},
        {{square(-20, 90), reversed(square(0, 20)), reversed(square(20, 40))}, non_zero, "outer 4 in -, hole 8 in 0, "},
        {{square(0, 90), {{0, 0}, {20, 40}, {40, 20}}}, non_zero, "outer 7 in -, "},
        // (-2, 2) to (1, 4) passes the pixel of (0, 4), to which the next edge leads back: no spike is left.
        {{{{0, 0}, {-2, 2}, {1, 4}, {0, 4}, {0, 9}, {10, 13}}, {{10, 14}, {16, 8}, {8, -7}}},
         even_odd,
         "outer 5 in -, outer 4 in -, "},
        // The edges beside (-1, -7) to (3, -9) cross within its reach, and it passes their pixel: no sliver is left.
        {{{{5, -8}, {-1, -7}, {3, -9}, {-2, 2}}}, even_odd, "outer 3 in -, "},
    };
    for (const auto& [rings, rule, expected] : cases) {
        const SliceResult region = regions::region_of(rings, rule);
        std::string text;
        for (const Contour& contour : region.contours) {
            text += std::string(contour.role == Role::outer ? "outer " : "hole ") + std::to_string(contour.point_count) +
                    " in " + (contour.parent < 0 ? "-" : std::to_string(contour.parent)) + ", ";
        }
        CHECK(text == expected);
        CHECK(regions::broken_promise(region) == "");
    }
}

TEST_CASE("fill rules fill places by their winding number, though contours cross themselves and share corners and lines",
          "[engine][fill]") {
    const unsigned seed = GENERATE(range(1U, 1 + rounds(400)));
    CAPTURE(seed);
    std::mt19937 random(seed);
    constexpr std::int32_t step = 1 << 20;
    Rings contours;
    for (std::size_t count = 1 + random() % 4; count > 0; --count) {
        contours.push_back(lattice_points(random, 1, 3 + random() % 8, 12, step)[0]);
    }
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        const SliceResult region = regions::region_of(contours, rule);
        REQUIRE(regions::broken_promise(region) == "");
        for (int i = 0; i < 60; ++i) {
            const Point near = contours[0][random() % contours[0].size()];
            const double reach = step * std::pow(10, between(random, -2, 1));
            const auto place = [&](std::int32_t from) { return from + between(random, -reach, reach); };
            const rings::PlaceOf<double> at{place(near.x), place(near.y)};
            const auto winding = [&](const Rings& rings) {
                int sum = 0;
                for (const Ring& ring : rings) {
                    sum += rings::winding(ring, at).value_or(0);
                }
                return sum;
            };
            INFO(name_of(rule) << " at " << at.x << ", " << at.y);
            REQUIRE((winding(regions::rings_of(region)) == 1) == regions::fills(rule, winding(contours)));
        }
    }
}

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double reach_mm = grid_limit * coarse_unit_mm;

/// The message with which slicing a cube on a grid of 0.5 mm is refused; empty where it is not.
std::string refusal_of(RegionRules rules) {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const auto result =
        slice(view_of(cube), {.heights_mm = {{5}}, .frame = {.grid_mm = coarse_unit_mm}, .region = std::move(rules)});
    return result ? std::string() : error_of(result).message;
}

/// By non-zero, where no rule is given.
RegionRules by(double RegionRules::*length, double mm, double miter_limit = 3) {
    RegionRules rules{.fill_rule = FillRule::non_zero, .miter_limit = miter_limit};
    rules.*length = mm;
    return rules;
}

TEST_CASE("rules of regions that cannot be kept are refused with what is possible", "[engine][regions]") {
    constexpr double RegionRules::*closing = &RegionRules::closing_mm;
    constexpr double RegionRules::*offset = &RegionRules::offset_mm;
    constexpr double RegionRules::*flag = &RegionRules::flag_closing_mm;
    constexpr FillRule none = FillRule::contours;
    std::vector<std::pair<RegionRules, std::string>> cases = {
        // a part of the message; empty where the rules are taken
        {by(closing, -1), "closing_mm must be finite and at least 0, not -1"},
        {by(offset, infinity), "offset_mm must be finite, not inf"},
        {by(offset, 0, 0.999), "miter_limit must be finite and at least 1, not 0.999"},
        {by(offset, -1), ""},
        {by(offset, 0, 1), ""},
        {by(offset, -0.25), "offset of -0.25 mm is under"},
        {by(offset, -reach_mm), "is beyond the grid"},
        {by(&RegionRules::simplify_mm, 0.25), "the tolerance of simplification"},
        {{.fill_rule = FillRule::positive, .fill_from = {{7, FillRule::positive}, {3, FillRule::even_odd}}},
         "fill rules by layer must be in ascending order: one from layer 7 on stands before one from layer 3 on"},
        {{.fill_rule = FillRule::positive, .fill_from = {{4, FillRule::positive}, {4, FillRule::even_odd}}},
         "from layer 4 on stands before one from layer 4 on"},
        {{.fill_rule = FillRule::positive, .fill_from = {{3, FillRule::positive}, {7, FillRule::even_odd}}}, ""},
        {{.fill_rule = static_cast<FillRule>(5)}, "fill_rule is none of its choices"},
        {{.fill_rule = FillRule::positive, .fill_from = {{1, static_cast<FillRule>(200)}}},
         "fill_from has a rule that is none of its choices"},
        {{.fill_rule = none, .flag_closing_mm = 1}, ""},  // a mark needs no region
    };
    for (const double bad : {-1.0, -infinity, infinity, not_a_number}) {
        cases.push_back({by(closing, bad), "closing_mm must be finite and at least 0, not"});
        cases.push_back({by(flag, bad), "flag_closing_mm must be finite and at least 0, not"});
        cases.push_back({by(&RegionRules::simplify_mm, bad), "simplify_mm must be finite and at least 0, not"});
        cases.push_back({by(offset, bad), std::abs(bad) == 1 ? "" : "offset_mm must be finite, not"});
        cases.push_back({by(offset, 0, bad), "miter_limit must be finite and at least 1, not"});
        cases.push_back({by(offset, 0, bad == -1 ? 0.999 : 0), "miter_limit must be finite and at least 1, not"});
    }
    for (double RegionRules::*const length : {closing, offset, flag}) {
        cases.push_back({by(length, std::nextafter(reach_mm, infinity), 1), "is beyond the grid"});
        cases.push_back({by(length, std::nextafter(reach_mm, infinity), 1), "it is at most 536870912 mm"});
        cases.push_back({by(length, reach_mm / 2, 4), "it is at most 134217728 mm"});
        cases.push_back({by(length, 0.49), "of 0.49 mm is under the grid unit of 0.5 mm: nothing would happen"});
        cases.push_back({by(length, 0.5), ""});
    }
    const std::pair<RegionRules, std::string> need_regions[] = {{{.closing_mm = 1}, "closing"},
                                                                {{.offset_mm = -1}, "offset"},
                                                                {{.drop_collinear = true}, "drop_collinear"},
                                                                {{.largest_only = true}, "largest_only"}};
    for (auto [rules, name] : need_regions) {
        cases.push_back({rules, name + " needs a region, but layer 0 has the fill rule contours, which makes none; choose "
                                       "another rule, such as non-zero"});
        rules.fill_rule = FillRule::non_zero;
        rules.fill_from = {{2, FillRule::positive}, {9, none}};
        cases.push_back({rules, name + " needs a region, but layer 9 has"});
        rules.fill_rule = none;
        rules.fill_from = {{0, FillRule::positive}};  // the first rule is in use for no layer
        cases.push_back({rules, ""});
    }
    const Point corners[] = {{0, 0}, {40, 0}, {40, 40}, {0, 40}};
    const std::span<const Point> square[] = {corners};
    for (const auto& [rules, message] : cases) {
        INFO(message);
        const std::string refusal = refusal_of(rules);
        CHECK(refusal.empty() == message.empty());
        CHECK_THAT(refusal, Contains(message));
        const auto region = region_of(square, rules, coarse_unit_mm);  // a caller's contours are held to the same rules
        CHECK((region ? std::string() : region.error().message) == refusal);
    }
    for (const double bad : {0.0, -1.0, infinity, not_a_number}) {
        CHECK_THAT(error_of(region_of(square, by(offset, 0), bad)).message,
                   Catch::StartsWith("the grid unit must be finite and above 0, not"));
    }
    CHECK(value_of(region_of(square, by(offset, 0), 0.5))[0].area_mm2() == 400);
}

TEST_CASE("layers of which the rules leave nothing are counted", "[engine][regions]") {
    // One plane below the solids, one through an inverted and an upright one, one through the inverted one alone.
    const shapes::Soup soup =
        shapes::joined({shapes::flipped(shapes::box({0, 0, 0}, {4, 4, 20})), shapes::box({10, 0, 0}, {14, 4, 10})});
    SliceOptions options = at_heights({-5, 5, 15});
    options.region.fill_rule = GENERATE(FillRule::contours, FillRule::non_zero, FillRule::positive);
    const SliceResult result = sliced(soup, options);
    CHECK(result.info.emptied_layers == (options.region.fill_rule == FillRule::positive ? 1 : 0));
    CHECK(result.layers[2].contour_count == (options.region.fill_rule == FillRule::positive ? 0 : 1));
}

TEST_CASE("the largest outer contour alone stays, with its holes", "[regions]") {
    std::mt19937 random(3);
    for (int number = 0; number < 1200; ++number) {
        const Rings rings = lattice_boxes(random, 2 + below(random, 6), 15, 10);
        const FillRule rule = std::array{FillRule::even_odd, FillRule::non_zero, FillRule::positive,
                                         FillRule::outermost}[static_cast<std::size_t>(number) % 4];
        const SliceResult whole = regions::region_of(rings, rule);
        const regions::Region all = regions::region_in(whole);
        std::size_t largest = 0;
        for (std::size_t r = 1; r < all.size(); ++r) {
            largest = regions::twice_area(all[r].corners) > regions::twice_area(all[largest].corners) ? r : largest;
        }
        regions::Region kept;
        for (std::size_t r = 0; r < all.size(); ++r) {
            if (r == largest || (all[r].hole && all[r].parent == static_cast<std::int64_t>(largest))) {
                kept.push_back({all[r].corners, all[r].hole, all[r].hole ? 0 : -1});
            }
        }
        const RegionRules rules{.fill_rule = rule, .largest_only = true};
        const SliceResult found = regions::region_of(rings, rules);
        INFO(name_of(rule) << " of " << regions::text_of(rings));
        REQUIRE(regions::broken_promise(whole) == "");
        REQUIRE(regions::fault_in(found) == "");
        REQUIRE(regions::difference(regions::canonical(kept), regions::region_in(found)) == "");
        REQUIRE(regions::dependence_on_order(rings, rules, found, random) == "");
    }
}

}  // namespace
