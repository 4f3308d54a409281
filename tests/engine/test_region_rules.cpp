// Which region rules are refused, and by which words.
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"

using lamella::FillRule;
using lamella::RegionRules;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

lamella::SliceOptions options_with(const std::function<void(RegionRules&)>& change) {
    lamella::SliceOptions options = at_heights({5});
    options.region.fill_rule = FillRule::non_zero;
    change(options.region);
    return options;
}

/// The message with which slicing a cube is refused, on a grid of 0.5 mm.
std::string refusal_of(const std::function<void(RegionRules&)>& change) {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    const lamella::Error error = failure_of(view_of(cube), options_with(change));
    CHECK(error.code == lamella::ErrorCode::invalid_argument);
    return error.message;
}

bool is_taken(const std::function<void(RegionRules&)>& change) {
    return slice(view_of(shapes::box({0, 0, 0}, {10, 10, 10})), options_with(change)).ok();
}

}  // namespace

TEST_CASE("lengths of regions that are no lengths are refused", "[engine][regions]") {
    using Catch::StartsWith;
    for (const double bad : {-1.0, -infinity, infinity, not_a_number}) {
        CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.closing_mm = bad; }),
                   StartsWith("the closing radius must be finite and not negative"));
        CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.flag_closing_mm = bad; }),
                   StartsWith("the radius of the mark for near contours must be finite and not negative"));
    }
    CHECK_THAT(refusal_of([](RegionRules& rules) { rules.closing_mm = -1; }), Catch::EndsWith("not -1 mm"));
    for (const double bad : {-infinity, infinity, not_a_number}) {
        CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.offset_mm = bad; }),
                   StartsWith("the offset must be finite, not"));
    }
    for (const double bad : {0.999, 0.0, -3.0, infinity, not_a_number}) {
        CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.miter_limit = bad; }),
                   StartsWith("the miter limit must be finite and at least 1, not"));
    }
    for (const double bad : {-1.0, not_a_number, 0.25}) {
        CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.simplify_mm = bad; }),
                   Catch::Contains("the tolerance of simplification"));
    }
    CHECK(is_taken([](RegionRules& rules) { rules.offset_mm = -1; }));
    CHECK(is_taken([](RegionRules& rules) { rules.miter_limit = 1; }));
}

TEST_CASE("radii beyond the grid or under its unit are refused with what is possible", "[engine][regions]") {
    const double reach_mm = lamella::grid_limit * coarse_unit_mm;
    using Member = double RegionRules::*;
    for (const Member length : {&RegionRules::closing_mm, &RegionRules::offset_mm, &RegionRules::flag_closing_mm}) {
        const auto asked = [&](double mm, double limit) {
            return [=](RegionRules& rules) {
                rules.*length = mm;
                rules.miter_limit = limit;
            };
        };
        CHECK_THAT(refusal_of(asked(std::nextafter(reach_mm, infinity), 1)),
                   Catch::Contains("is beyond the grid") && Catch::EndsWith("it is at most 536870912 mm"));
        CHECK_THAT(refusal_of(asked(reach_mm / 2, 4)), Catch::EndsWith("it is at most 134217728 mm"));
        CHECK_THAT(refusal_of(asked(0.49, 3)),
                   Catch::EndsWith("of 0.49 mm is under the grid unit of 0.5 mm: nothing would happen"));
        CHECK(is_taken(asked(0.5, 3)));
    }
    CHECK_THAT(refusal_of([](RegionRules& rules) { rules.offset_mm = -0.25; }),
               Catch::Contains("offset of -0.25 mm is under"));
    CHECK_THAT(refusal_of([&](RegionRules& rules) { rules.offset_mm = -reach_mm; }), Catch::Contains("is beyond the grid"));
}

TEST_CASE("rules by layer must ascend", "[engine][regions]") {
    const auto from = [](std::uint64_t first, std::uint64_t second) {
        return [=](RegionRules& rules) { rules.fill_from = {{first, FillRule::positive}, {second, FillRule::even_odd}}; };
    };
    CHECK(refusal_of(from(7, 3)) ==
          "fill rules by layer must be in ascending order: one from layer 7 on stands before one from "
          "layer 3 on");
    CHECK_THAT(refusal_of(from(4, 4)), Catch::Contains("from layer 4 on stands before one from layer 4 on"));
    CHECK(is_taken(from(3, 7)));
    CHECK(refusal_of([](RegionRules& rules) { rules.fill_rule = static_cast<FillRule>(5); }) ==
          "there is no such fill rule");
    CHECK(refusal_of([](RegionRules& rules) {
              rules.fill_from = {{1, static_cast<FillRule>(200)}};
          }) == "there is no such fill rule");
}

TEST_CASE("what needs a region is refused where a layer has none", "[engine][regions]") {
    struct Case {
        void (*ask)(RegionRules&);
        std::string name;
    };
    const Case cases[] = {{[](RegionRules& rules) { rules.closing_mm = 1; }, "closing"},
                          {[](RegionRules& rules) { rules.offset_mm = -1; }, "an offset"},
                          {[](RegionRules& rules) { rules.drop_collinear = true; }, "dropping collinear points"},
                          {[](RegionRules& rules) { rules.largest_only = true; }, "keeping the largest contour only"}};
    for (const Case& one : cases) {
        CHECK(refusal_of([&](RegionRules& rules) {
                  one.ask(rules);
                  rules.fill_rule = FillRule::contours;
              }) == one.name +
                        " needs a region, but layer 0 has the fill rule contours, which makes none; choose another rule, "
                        "such as non-zero");
        CHECK_THAT(refusal_of([&](RegionRules& rules) {
                       one.ask(rules);
                       rules.fill_from = {{2, FillRule::positive}, {9, FillRule::contours}};
                   }),
                   Catch::StartsWith(one.name + " needs a region, but layer 9 has"));
        CHECK(is_taken([&](RegionRules& rules) {  // the first rule is in use for no layer
            one.ask(rules);
            rules.fill_rule = FillRule::contours;
            rules.fill_from = {{0, FillRule::positive}};
        }));
    }
    CHECK(is_taken([](RegionRules& rules) {  // a mark changes nothing
        rules.fill_rule = FillRule::contours;
        rules.flag_closing_mm = 1;
    }));
}

TEST_CASE("layers of which the rules leave nothing are counted", "[engine][regions]") {
    // One plane below the solids, one through an inverted and an upright one, one through the inverted one alone.
    const shapes::Soup soup =
        shapes::joined({shapes::flipped(shapes::box({0, 0, 0}, {4, 4, 20})), shapes::box({10, 0, 0}, {14, 4, 10})});
    lamella::SliceOptions options = at_heights({-5, 5, 15});
    options.region.fill_rule = GENERATE(FillRule::contours, FillRule::non_zero, FillRule::positive);
    const lamella::SliceResult result = sliced(soup, options);
    CHECK(result.info.emptied_layers == (options.region.fill_rule == FillRule::positive ? 1 : 0));
    CHECK(result.layers[2].contour_count == (options.region.fill_rule == FillRule::positive ? 0 : 1));
}

TEST_CASE("a caller's own contours are held to the same rules", "[engine][regions]") {
    const lamella::Point corners[] = {{0, 0}, {40, 0}, {40, 40}, {0, 40}};
    const std::span<const lamella::Point> square[] = {corners};
    const auto refusal = [&](const RegionRules& rules, double unit_mm) {
        const lamella::Result<lamella::SliceResult> region = region_of(square, rules, unit_mm);
        return region ? std::string("taken") : region.error().message;
    };
    RegionRules rules;
    rules.fill_rule = FillRule::non_zero;
    CHECK(refusal(rules, 0.5) == "taken");
    CHECK((*region_of(square, rules, 0.5))[0].area_mm2() == 400);
    for (const double bad : {0.0, -1.0, infinity, not_a_number}) {
        CHECK_THAT(refusal(rules, bad), Catch::StartsWith("the grid unit must be finite and above 0, not"));
    }
    rules.closing_mm = -1;
    CHECK_THAT(refusal(rules, 0.5), Catch::StartsWith("the closing radius must be finite"));
    rules.closing_mm = 0.2;
    CHECK_THAT(refusal(rules, 0.5), Catch::Contains("is under the grid unit of 0.5 mm"));
    rules.closing_mm = 1;
    rules.fill_rule = FillRule::contours;
    CHECK_THAT(refusal(rules, 0.5), Catch::StartsWith("closing needs a region, but layer 0"));
}
