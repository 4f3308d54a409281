// Regions by each fill rule, and closed gaps, compared with written-down answers.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "lamella/assemble.hpp"

using lamella::FillRule;
using lamella::Role;
using lamella::SliceResult;

namespace {

constexpr FillRule all_rules[] = {FillRule::contours, FillRule::even_odd, FillRule::non_zero, FillRule::positive};

/// Slices at mid-height solids that extend from z = 0 to 10, on the coarse grid.
SliceResult filled(const shapes::Soup& soup, FillRule rule, double close_gaps_mm = 0) {
    lamella::SliceOptions options = at_heights({5});
    options.region.fill_rule = rule;
    options.close_gaps_mm = close_gaps_mm;
    SliceResult result = sliced(soup, options);
    CHECK(result.region.fill_rule == rule);
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
        const double area = result.area_mm2(result.layers[0]);
        lines.push_back(count(Role::outer) + " outer, " + count(Role::hole) + " hole, " +
                        (std::isnan(area) ? count(Role::open) + " open" : std::to_string(static_cast<int>(area))));
    }
    return lines;
}

using Lines = std::vector<std::string>;

shapes::Soup square(double x, double y, double size) {
    return shapes::box({x, y, 0}, {x + size, y + size, 10});
}

/// A box without its front side, the one at low y.
shapes::Soup without_front(shapes::Soup box) {
    box.erase(box.begin() + 4 * 9, box.begin() + 6 * 9);
    return box;
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

TEST_CASE("fill rules: two overlapping cubes are united, or their overlap is empty by even-odd", "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 10), square(5, 5, 10)})) ==
          Lines{"2 outer, 0 hole, 200", "2 outer, 0 hole, 150", "1 outer, 0 hole, 175", "1 outer, 0 hole, 175"});
}

TEST_CASE("fill rules: overlapping cubes with coplanar sides of equal orientation", "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 10), square(5, 0, 10)})) ==
          Lines{"2 outer, 0 hole, 200", "2 outer, 0 hole, 100", "1 outer, 0 hole, 150", "1 outer, 0 hole, 150"});
}

TEST_CASE("fill rules: touching cubes, whose common side has two faces of opposite orientation, are united",
          "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 10), square(10, 0, 10)})) ==
          Lines{"2 outer, 0 hole, 200", "1 outer, 0 hole, 200", "1 outer, 0 hole, 200", "1 outer, 0 hole, 200"});
}

TEST_CASE("fill rules: touching boxes are united even if their walls are triangulated differently", "[engine][fill]") {
    shapes::Soup soup;
    for (int x = 0; x < 7; ++x) {
        for (int y = 0; y < 7; ++y) {
            soup = shapes::joined({soup, shapes::box({3.0 * x, 5.0 * y, 0}, {3.0 * x + 3, 5.0 * y + 5, 10})});
        }
    }
    for (const FillRule rule : {FillRule::even_odd, FillRule::non_zero, FillRule::positive}) {
        lamella::SliceOptions options = at_heights({4.3});
        options.unit_mm = lamella::default_unit_mm;
        options.region.fill_rule = rule;
        options.region.drop_collinear = true;
        const SliceResult result = sliced(soup, options);
        REQUIRE(result.contours.size() == 1);
        CHECK(result.contours[0].point_count == 4);
        CHECK(result.area_mm2(result.layers[0]) == Approx(21.0 * 35));
    }
}

TEST_CASE("fill rules: a body in a hole that several bodies form has that hole as parent", "[engine][fill]") {
    const shapes::Soup frame = shapes::joined({shapes::box({0, 0, 0}, {30, 5, 10}), shapes::box({0, 25, 0}, {30, 30, 10}),
                                               shapes::box({0, 1, 0}, {5, 29, 10}), shapes::box({25, 1, 0}, {30, 29, 10})});
    for (const FillRule rule : {FillRule::non_zero, FillRule::positive}) {
        const SliceResult result = filled(shapes::joined({frame, square(10, 10, 10)}), rule);
        REQUIRE(result.contours.size() == 3);
        CHECK(result.contours[2].role == Role::outer);
        REQUIRE(result.contours[2].parent >= 0);
        CHECK(result.contours[static_cast<std::size_t>(result.contours[2].parent)].role == Role::hole);
    }
}

TEST_CASE("fill rules: a solid insert in a solid is empty by even-odd, else filled", "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 30), square(10, 10, 10)})) ==
          Lines{"2 outer, 0 hole, 1000", "1 outer, 1 hole, 800", "1 outer, 0 hole, 900", "1 outer, 0 hole, 900"});
}

TEST_CASE("fill rules: a cavity is a hole by every rule", "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 30), shapes::flipped(square(10, 10, 10))})) ==
          Lines(4, "1 outer, 1 hole, 800"));
}

TEST_CASE("fill rules: a body exported twice is empty by even-odd, else filled once", "[engine][fill]") {
    CHECK(regions(shapes::joined({square(0, 0, 10), square(0, 0, 10)})) ==
          Lines{"2 outer, 0 hole, 200", "0 outer, 0 hole, 0", "1 outer, 0 hole, 100", "1 outer, 0 hole, 100"});
}

TEST_CASE("fill rules: an inverted body across one exported twice counts negatively", "[engine][fill]") {
    const shapes::Soup twice = shapes::joined({square(0, 0, 10), square(0, 0, 10)});
    const Lines lines = regions(shapes::joined({twice, shapes::flipped(square(5, 5, 10))}));
    CHECK(Lines(lines.begin() + 1, lines.end()) ==
          Lines{"1 outer, 0 hole, 100", "1 outer, 0 hole, 175", "1 outer, 0 hole, 100"});
}

TEST_CASE("fill rules: an inverted body is empty by `positive`, else filled", "[engine][fill]") {
    CHECK(regions(shapes::flipped(square(0, 0, 10))) ==
          Lines{"1 outer, 0 hole, 100", "1 outer, 0 hole, 100", "1 outer, 0 hole, 100", "0 outer, 0 hole, 0"});
}

TEST_CASE("fill rules: an internal wall stays an open polyline", "[engine][fill]") {
    const shapes::Soup wall = shapes::joined(
        {shapes::triangle({2, 5, 0}, {8, 5, 0}, {8, 5, 10}), shapes::triangle({2, 5, 0}, {8, 5, 10}, {2, 5, 10})});
    CHECK(regions(shapes::joined({square(0, 0, 10), wall})) == Lines(4, "1 outer, 0 hole, 1 open"));
}

TEST_CASE("fill rules: layers are counted where shells turned inwards take solid away", "[engine][fill]") {
    const auto cancelled = [](const shapes::Soup& soup, FillRule rule = FillRule::non_zero) {
        return filled(soup, rule).summary.cancelled_layers;
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

TEST_CASE("fill rules: threads, bands and triangle order do not change the bytes", "[engine][fill][threads]") {
    shapes::Soup soup;
    std::mt19937 random(4);
    for (int i = 0; i < 12; ++i) {
        const auto at = [&] { return static_cast<double>(random() % 4000) / 1000.0; };
        const shapes::Soup ball = shapes::octasphere({at(), at(), at()}, 2, 2);
        soup = shapes::joined({soup, i % 4 == 3 ? shapes::flipped(ball) : ball});
    }
    for (const FillRule rule : all_rules) {
        lamella::SliceOptions options = uniform(0.05);
        options.region.fill_rule = rule;
        const std::uint64_t hash = hash_result(sliced(soup, options));
        for (int turn = 0; turn < 3; ++turn) {
            options.control.threads = turn + 1;
            options.tuning.band_planes = turn * 7;
            options.tuning.form = turn == 2 ? lamella::ContourForm::assembled : lamella::ContourForm::swept;
            for (std::size_t t = soup.size() / 9 - 1; t > 0; --t) {
                const std::size_t other = random() % (t + 1);
                std::swap_ranges(&soup[9 * t], &soup[9 * t] + 9, &soup[9 * other]);
            }
            CHECK(hash_result(sliced(soup, options)) == hash);
        }
    }
}

TEST_CASE("gaps up to the requested length are closed, and each is reported", "[engine][gaps]") {
    const shapes::Soup soup = without_front(square(0, 0, 10));
    const SliceResult open = filled(soup, FillRule::contours);
    REQUIRE(open.contours.size() == 1);
    CHECK(open.contours[0].role == Role::open);
    CHECK(open.closed_gaps.empty());
    const SliceResult short_reach = filled(soup, FillRule::contours, 9.9);
    CHECK(hash_result(short_reach) == hash_result(open));
    CHECK(short_reach.closed_gaps.empty());

    const SliceResult closed = filled(soup, FillRule::contours, 10);
    REQUIRE(closed.contours.size() == 1);
    CHECK(closed.contours[0].role == Role::outer);
    CHECK((closed.contours[0].flags & lamella::gap_closed) != 0);
    CHECK(closed.area_mm2(closed.layers[0]) == 100);
    REQUIRE(closed.closed_gaps.size() == 1);
    CHECK(closed.closed_gaps[0].layer == 0);
    CHECK(closed.length_mm(closed.closed_gaps[0]) == 10);
    // The solid is on the left, so along the missing side the contour runs towards larger x.
    CHECK(closed.closed_gaps[0].from == lamella::Point{0, 0});
    CHECK(closed.closed_gaps[0].to == lamella::Point{20, 0});
}

TEST_CASE("the nearest ends are joined first", "[engine][gaps]") {
    // Two walls of a channel. One has a gap of 4 in its middle; the walls are 8 apart.
    const auto wall = [](double x0, double x1, double y) {
        return shapes::joined(
            {shapes::triangle({x0, y, 0}, {x1, y, 0}, {x1, y, 10}), shapes::triangle({x0, y, 0}, {x1, y, 10}, {x0, y, 10})});
    };
    const shapes::Soup soup = shapes::joined({wall(0, 10, 0), wall(14, 24, 0), wall(24, 0, 8)});
    const SliceResult near = filled(soup, FillRule::contours, 5);
    REQUIRE(near.closed_gaps.size() == 1);
    CHECK(near.length_mm(near.closed_gaps[0]) == 4);
    CHECK(near.summary.open_contours == 2);
    const SliceResult all = filled(soup, FillRule::contours, 8);
    REQUIRE(all.closed_gaps.size() == 3);
    CHECK(all.summary.open_contours == 0);
    CHECK(all.contours.size() == 1);
    CHECK(all.area_mm2(all.layers[0]) == 24 * 8);
    CHECK(std::accumulate(all.closed_gaps.begin(), all.closed_gaps.end(), 0.0,
                          [&](double sum, const auto& gap) { return sum + all.length_mm(gap); }) == 4 + 8 + 8);
}

TEST_CASE("closing gaps: threads, bands and triangle order do not change the bytes", "[engine][gaps][threads]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 4);
    std::mt19937 random(8);
    for (int lost = 0; lost < 60; ++lost) {
        const auto t = static_cast<std::ptrdiff_t>(random() % (soup.size() / 9));
        soup.erase(soup.begin() + 9 * t, soup.begin() + 9 * t + 9);
    }
    lamella::SliceOptions options = uniform(0.05);
    const std::uint64_t open = sliced(soup, options).summary.open_contours;
    options.close_gaps_mm = 1;
    const SliceResult closed = sliced(soup, options);
    CHECK(open > 50);
    CHECK(closed.summary.open_contours < open / 2);
    CHECK(closed.closed_gaps.size() >= open - closed.summary.open_contours);
    for (int turn = 0; turn < 3; ++turn) {
        options.control.threads = turn + 1;
        options.tuning.band_planes = turn * 9;
        options.tuning.form = turn == 1 ? lamella::ContourForm::assembled : lamella::ContourForm::swept;
        for (std::size_t t = soup.size() / 9 - 1; t > 0; --t) {
            const std::size_t other = random() % (t + 1);
            std::swap_ranges(&soup[9 * t], &soup[9 * t] + 9, &soup[9 * other]);
        }
        const SliceResult again = sliced(soup, options);
        CHECK(hash_result(again) == hash_result(closed));
        REQUIRE(again.closed_gaps.size() == closed.closed_gaps.size());
        CHECK(
            std::equal(again.closed_gaps.begin(), again.closed_gaps.end(), closed.closed_gaps.begin(),
                       [](const auto& a, const auto& b) { return a.layer == b.layer && a.from == b.from && a.to == b.to; }));
    }
    for (const double reach : {-0.5, std::nan(""), HUGE_VAL}) {
        options.close_gaps_mm = reach;
        CHECK(failure_of(view_of(soup), options).code == lamella::ErrorCode::invalid_argument);
    }
}

TEST_CASE("fill rules: rods across each other by the hundred", "[engine][fill]") {
#ifdef LAMELLA_TESTS_SANITIZED
    constexpr int rods = 100;
#else
    constexpr int rods = 300;
#endif
    constexpr double side = 2 * rods;
    shapes::Soup soup;
    for (int i = 0; i < rods; ++i) {
        soup = shapes::joined({soup, shapes::box({2.0 * i, 0, 5}, {2.0 * i + 1, side, 10}),
                               shapes::box({0, 2.0 * i, 5}, {side, 2.0 * i + 1, 10})});
    }
    lamella::SliceOptions options = at_heights({2, 6});
    options.region.fill_rule = FillRule::non_zero;
    const SliceResult united = sliced(soup, options);
    CHECK(united.layers[0].contour_count == 0);
    CHECK(united.layers[1].contour_count == 1 + (rods - 1) * (rods - 1));
    CHECK(united.area_mm2(united.layers[1]) == 2 * rods * side - rods * rods);
    options.region.fill_rule = FillRule::even_odd;
    const SliceResult odd = sliced(soup, options);
    CHECK(odd.area_mm2(odd.layers[1]) == 2 * rods * side - 2 * rods * rods);
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
        const lamella::Result<lamella::LayerContours> region = lamella::region_of(contours, rules);
        REQUIRE(region.ok());
        CHECK(region->contours.size() == contours.size());
        for (const lamella::Contour& contour : region->contours) {
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
        const lamella::Result<lamella::LayerContours> region = lamella::region_of(views, rules);
        REQUIRE(region.ok());
        std::string text;
        for (const lamella::Contour& contour : region->contours) {
            text += (contour.role == Role::outer ? "outer " : "hole ") + std::to_string(contour.point_count) + " ";
        }
        return text;
    };
    CHECK(contours_of({square(0, 20), square(10, 30)}) == "outer 8 ");  // the example of region.hpp, finer
    CHECK(contours_of({square(0, 20), square(20, 40)}) == "outer 4 outer 4 ");
    CHECK(contours_of({square(-20, 90), hole(0, 20), hole(20, 40)}) == "outer 4 hole 8 ");
    CHECK(contours_of({square(0, 90), {{0, 0}, {20, 40}, {40, 20}}}) == "outer 7 ");
}
