// Regions by each fill rule, compared with written-down answers.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

using lamella::FillRule;
using lamella::Role;
using lamella::SliceResult;

namespace {

constexpr FillRule all_rules[] = {FillRule::contours, FillRule::even_odd, FillRule::non_zero, FillRule::positive};

/// Slices at mid-height solids that extend from z = 0 to 10, on the coarse grid.
SliceResult filled(const shapes::Soup& soup, FillRule rule) {
    lamella::SliceOptions options = at_heights({5});
    options.region.fill_rule = rule;
    SliceResult result = sliced(soup, options);
    CHECK(result.info.options.region.fill_rule == rule);
    return result;
}

/// One line for each rule: "1 outer, 0 hole, 100", with the area last, or "1 open" where it is not known.
std::vector<std::string> regions(const shapes::Soup& soup) {
    std::vector<std::string> lines;
    for (const FillRule rule : all_rules) {
        const SliceResult result = filled(soup, rule);
        const auto count = [&](Role role) {
            return std::to_string(std::count_if(result.contours.begin(), result.contours.end(),
                                                [role](const lamella::Contour& contour) { return contour.role == role; }));
        };
        const double area = result[0].area_mm2();
        lines.push_back(count(Role::outer) + " outer, " + count(Role::hole) + " hole, " +
                        (std::isnan(area) ? count(Role::open) + " open" : std::to_string(static_cast<int>(area))));
    }
    return lines;
}

using Lines = std::vector<std::string>;

shapes::Soup square(double x, double y, double size) {
    return shapes::box({x, y, 0}, {x + size, y + size, 10});
}

}  // namespace

TEST_CASE("fill rules: all rules give one solid the same region, equal to that of `contours` to the byte",
          "[engine][fill]") {
    CHECK(regions(square(0, 0, 10)) == Lines(4, "1 outer, 0 hole, 100"));
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    lamella::SliceOptions options = uniform(0.3);
    const SliceResult walked = sliced(ball, options);
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        options.region.fill_rule = rule;
        const SliceResult result = sliced(ball, options);
        REQUIRE(result.points.size() == walked.points.size());
        CHECK(std::equal(result.points.begin(), result.points.end(), walked.points.begin()));
    }
}

TEST_CASE("fill rules: what becomes of solids that overlap, touch, lie in each other or are inverted", "[engine][fill]") {
    struct Case {
        const char* name;
        shapes::Soup soup;
        Lines expected;  ///< by contours, even-odd, non-zero and positive
    };
    const shapes::Soup body = square(0, 0, 10);
    const shapes::Soup large = square(0, 0, 30);
    const shapes::Soup inner = square(10, 10, 10);
    const Case cases[] = {
        {"two that overlap",
         shapes::joined({body, square(5, 5, 10)}),
         {"2 outer, 0 hole, 200", "2 outer, 0 hole, 150", "1 outer, 0 hole, 175", "1 outer, 0 hole, 175"}},
        {"coplanar sides of equal orientation",
         shapes::joined({body, square(5, 0, 10)}),
         {"2 outer, 0 hole, 200", "2 outer, 0 hole, 100", "1 outer, 0 hole, 150", "1 outer, 0 hole, 150"}},
        {"a common side of two faces",
         shapes::joined({body, square(10, 0, 10)}),
         {"2 outer, 0 hole, 200", "1 outer, 0 hole, 200", "1 outer, 0 hole, 200", "1 outer, 0 hole, 200"}},
        {"a solid insert in a solid",
         shapes::joined({large, inner}),
         {"2 outer, 0 hole, 1000", "1 outer, 1 hole, 800", "1 outer, 0 hole, 900", "1 outer, 0 hole, 900"}},
        {"a cavity", shapes::joined({large, shapes::flipped(inner)}), Lines(4, "1 outer, 1 hole, 800")},
        {"exported twice",
         shapes::joined({body, body}),
         {"2 outer, 0 hole, 200", "0 outer, 0 hole, 0", "1 outer, 0 hole, 100", "1 outer, 0 hole, 100"}},
        {"inverted",
         shapes::flipped(body),
         {"1 outer, 0 hole, 100", "1 outer, 0 hole, 100", "1 outer, 0 hole, 100", "0 outer, 0 hole, 0"}},
        {"an internal wall, which stays an open polyline", shapes::joined({body, shapes::wall({2, 5}, {8, 5})}),
         Lines(4, "1 outer, 0 hole, 1 open")}};
    for (const Case& one : cases) {
        INFO(one.name);
        CHECK(regions(one.soup) == one.expected);
    }
    // An inverted body across one exported twice counts negatively.
    const Lines lines = regions(shapes::joined({body, body, shapes::flipped(square(5, 5, 10))}));
    CHECK(Lines(lines.begin() + 1, lines.end()) ==
          Lines{"1 outer, 0 hole, 100", "1 outer, 0 hole, 175", "1 outer, 0 hole, 100"});
}

TEST_CASE("fill rules: touching boxes are united even if their walls are triangulated differently", "[engine][fill]") {
    shapes::Soup soup;
    for (int x = 0; x < 7; ++x) {
        for (int y = 0; y < 7; ++y) {
            soup = shapes::joined({soup, shapes::box({3.0 * x, 5.0 * y, 0}, {3.0 * x + 3, 5.0 * y + 5, 10})});
        }
    }
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        lamella::SliceOptions options = at_heights({4.3}, lamella::default_grid_mm);
        options.region.fill_rule = rule;
        options.region.drop_collinear = true;
        const SliceResult result = sliced(soup, options);
        REQUIRE(result.contours.size() == 1);
        CHECK(result.contours[0].point_count == 4);
        CHECK(result[0].area_mm2() == Approx(21.0 * 35));
    }
}

TEST_CASE("fill rules: layers are counted where shells turned inwards take solid away", "[engine][fill]") {
    const auto cancelled = [](const shapes::Soup& soup, FillRule rule = FillRule::non_zero) {
        return filled(soup, rule).info.cancelled_layers;
    };
    const shapes::Soup body = square(0, 0, 10);
    const shapes::Soup across = shapes::flipped(square(5, 5, 10));
    CHECK(cancelled(shapes::joined({body, across})) == 1);
    CHECK(cancelled(shapes::joined({body, across}), FillRule::even_odd) == 0);
    CHECK(cancelled(shapes::joined({body, shapes::flipped(body)})) == 1);
    CHECK(cancelled(shapes::joined({body, body, square(5, 5, 10)})) == 0);
    CHECK(cancelled(shapes::joined({body, shapes::flipped(square(0, 2, 4))})) == 0);    // a pocket at a face
    CHECK(cancelled(shapes::joined({body, shapes::flipped(square(20, 0, 10))})) == 0);  // apart
    CHECK(cancelled(shapes::flipped(shapes::joined({body, square(5, 5, 10)}))) == 0);   // inside out as a whole
}

TEST_CASE("fill rules: contours that meet count the windings of shells around them", "[engine][fill]") {
    // Three shells around two overlapping squares. The overlap then has winding number 5. By even-odd it touches the solid
    // around it in two points, and the hole between them passes both points twice.
    const shapes::Soup shells = shapes::joined({square(-30, -30, 80), square(-20, -20, 60), square(-10, -10, 40)});
    const shapes::Soup pair = shapes::joined({square(0, 0, 10), square(5, 5, 10)});
    CHECK(regions(shapes::joined({shells, pair})) ==
          Lines{"5 outer, 0 hole, 11800", "3 outer, 2 hole, 4250", "1 outer, 0 hole, 6400", "1 outer, 0 hole, 6400"});
    CHECK(regions(shapes::joined({shells, shapes::flipped(pair)}))[1] == "3 outer, 2 hole, 4250");
    // Around the pair, three inverted shells make the winding number zero, and a fourth makes it negative.
    const shapes::Soup undone = shapes::joined({shells, shapes::flipped(square(-5, -5, 30)),
                                                shapes::flipped(square(-4, -4, 28)), shapes::flipped(square(-3, -3, 26))});
    CHECK(regions(shapes::joined({undone, pair}))[2] == "2 outer, 1 hole, " + std::to_string(6400 - 26 * 26 + 175));
    const shapes::Soup below = shapes::joined({undone, shapes::flipped(square(-2, -2, 24))});
    CHECK(regions(shapes::joined({below, pair}))[3] == "2 outer, 1 hole, " + std::to_string(6400 - 26 * 26 + 25));
}

TEST_CASE("fill rules: bodies that touch the tip of a spike into their hole lie in the hole", "[engine][fill]") {
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
    using Points = std::vector<lamella::Point>;
    const Points around = {{-100, -100}, {200, -100}, {200, 200}, {-100, 200}};
    const Points hole = {{0, 0}, {0, 100}, {100, 100}, {100, 60}, {50, 50}, {100, 40}, {100, 0}};
    const Points above = {{50, 50}, {70, 90}, {60, 90}};
    const Points below = {{50, 50}, {60, 20}, {70, 20}};
    lamella::RegionRules rules;
    rules.fill_rule = FillRule::non_zero;
    const auto check = [&](const std::vector<std::span<const lamella::Point>>& contours) {
        const lamella::SliceResult region = value_of(lamella::region_of(contours, rules));
        CHECK(region.contours.size() == contours.size());
        for (const lamella::Contour& contour : region.contours) {
            const bool small = contour.point_count == 3;
            CHECK(contour.parent == (small ? 1 : contour.role == Role::hole ? 0 : -1));
            CHECK(contour.role == (contour.point_count == 7 ? Role::hole : Role::outer));
        }
    };
    check({around, hole, above});
    check({around, hole, below});
    check({around, hole, above, below});
}

TEST_CASE("fill rules: region_of joins what is empty in a point, but not what is solid", "[engine][fill]") {
    using Points = std::vector<lamella::Point>;
    const auto square = [](std::int32_t low, std::int32_t high) -> Points {
        return {{low, low}, {high, low}, {high, high}, {low, high}};
    };
    const auto hole = [&](std::int32_t low, std::int32_t high) {
        Points points = square(low, high);
        std::reverse(points.begin(), points.end());
        return points;
    };
    lamella::RegionRules rules;
    rules.fill_rule = FillRule::non_zero;
    // "outer 4 hole 8": the points of each contour.
    const auto contours_of = [&](const std::vector<Points>& contours) {
        const std::vector<std::span<const lamella::Point>> views(contours.begin(), contours.end());
        const lamella::SliceResult region = value_of(lamella::region_of(views, rules));
        std::string text;
        for (const lamella::Contour& contour : region.contours) {
            text += (contour.role == Role::outer ? "outer " : "hole ") + std::to_string(contour.point_count) + " ";
        }
        return text;
    };
    CHECK(contours_of({square(0, 20), square(10, 30)}) == "outer 8 ");  // the example of layers.hpp, finer
    CHECK(contours_of({square(0, 20), square(20, 40)}) == "outer 4 outer 4 ");
    CHECK(contours_of({square(-20, 90), hole(0, 20), hole(20, 40)}) == "outer 4 hole 8 ");
    CHECK(contours_of({square(0, 90), {{0, 0}, {20, 40}, {40, 20}}}) == "outer 7 ");
}
