// Which region rules are refused, and by which words.
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

using Catch::Contains;
using lamella::FillRule;
using lamella::RegionRules;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double reach_mm = lamella::grid_limit * coarse_unit_mm;

/// The message with which slicing a cube on a grid of 0.5 mm is refused; empty where it is not.
std::string refusal_of(RegionRules rules) {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {10, 10, 10});
    lamella::SliceOptions options = at_heights({5});
    options.region = std::move(rules);
    const auto result = slice(view_of(cube), options);
    return result ? std::string() : error_of(result).message;
}

/// By non-zero, where no rule is given.
RegionRules by(double RegionRules::*length, double mm, double miter_limit = 3) {
    RegionRules rules{.fill_rule = FillRule::non_zero, .miter_limit = miter_limit};
    rules.*length = mm;
    return rules;
}

RegionRules from(FillRule rule, std::vector<lamella::FillFrom> later) {
    return {.fill_rule = rule, .fill_from = std::move(later)};
}

}  // namespace

TEST_CASE("rules of regions that cannot be kept are refused with what is possible", "[engine][regions]") {
    constexpr double RegionRules::*closing = &RegionRules::closing_mm;
    constexpr double RegionRules::*offset = &RegionRules::offset_mm;
    constexpr double RegionRules::*flag = &RegionRules::flag_closing_mm;
    constexpr FillRule none = FillRule::contours;
    struct Case {
        RegionRules rules;
        std::string message;  ///< a part of it; empty where the rules are taken
    };
    std::vector<Case> cases = {
        {by(closing, -1), "not -1 mm"},
        {by(offset, -1), ""},
        {by(offset, 0, 1), ""},
        {by(offset, -0.25), "offset of -0.25 mm is under"},
        {by(offset, -reach_mm), "is beyond the grid"},
        {by(&RegionRules::simplify_mm, 0.25), "the tolerance of simplification"},
        {from(FillRule::positive, {{7, FillRule::positive}, {3, FillRule::even_odd}}),
         "fill rules by layer must be in ascending order: one from layer 7 on stands before one from layer 3 on"},
        {from(FillRule::positive, {{4, FillRule::positive}, {4, FillRule::even_odd}}),
         "from layer 4 on stands before one from layer 4 on"},
        {from(FillRule::positive, {{3, FillRule::positive}, {7, FillRule::even_odd}}), ""},
        {from(static_cast<FillRule>(5), {}), "there is no such fill rule"},
        {from(FillRule::positive, {{1, static_cast<FillRule>(200)}}), "there is no such fill rule"},
        {{.fill_rule = none, .flag_closing_mm = 1}, ""},  // a mark needs no region
    };
    for (const double bad : {-1.0, -infinity, infinity, not_a_number}) {
        cases.push_back({by(closing, bad), "the closing radius must be finite and not negative"});
        cases.push_back({by(flag, bad), "the radius of the mark for near contours must be finite and not negative"});
        cases.push_back({by(&RegionRules::simplify_mm, bad), "the tolerance of simplification"});
        cases.push_back({by(offset, bad), std::abs(bad) == 1 ? "" : "the offset must be finite, not"});
        cases.push_back({by(offset, 0, bad), "the miter limit must be finite and at least 1, not"});
        cases.push_back({by(offset, 0, bad == -1 ? 0.999 : 0), "the miter limit must be finite and at least 1, not"});
    }
    for (double RegionRules::*const length : {closing, offset, flag}) {
        cases.push_back({by(length, std::nextafter(reach_mm, infinity), 1), "is beyond the grid"});
        cases.push_back({by(length, std::nextafter(reach_mm, infinity), 1), "it is at most 536870912 mm"});
        cases.push_back({by(length, reach_mm / 2, 4), "it is at most 134217728 mm"});
        cases.push_back({by(length, 0.49), "of 0.49 mm is under the grid unit of 0.5 mm: nothing would happen"});
        cases.push_back({by(length, 0.5), ""});
    }
    const std::pair<RegionRules, std::string> need_regions[] = {
        {{.closing_mm = 1}, "closing"},
        {{.offset_mm = -1}, "an offset"},
        {{.drop_collinear = true}, "dropping collinear points"},
        {{.largest_only = true}, "keeping the largest contour only"}};
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
    const lamella::Point corners[] = {{0, 0}, {40, 0}, {40, 40}, {0, 40}};
    const std::span<const lamella::Point> square[] = {corners};
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
    lamella::SliceOptions options = at_heights({-5, 5, 15});
    options.region.fill_rule = GENERATE(FillRule::contours, FillRule::non_zero, FillRule::positive);
    const lamella::SliceResult result = sliced(soup, options);
    CHECK(result.info.emptied_layers == (options.region.fill_rule == FillRule::positive ? 1 : 0));
    CHECK(result.layers[2].contour_count == (options.region.fill_rule == FillRule::positive ? 0 : 1));
}
