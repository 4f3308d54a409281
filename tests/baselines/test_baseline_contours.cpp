// The contour algorithms that the paper describes or compares find the engine's contours.
#include <map>
#include <set>

#include <catch2/catch.hpp>

#include "baselines/agreement.hpp"
#include "methods.hpp"

using agreement::Case;
using lamella::Point;
using lamella::Role;
using lamella::baselines::ContourMethod;
using lamella::baselines::Contours;
using lamella::baselines::hashed_contours;
using lamella::baselines::Polyline;
using lamella::baselines::SegmentLists;
using lamella::baselines::trivial_contours;
using lamella::models::Shape;

namespace {

/// Only the trivial method keeps the orientation of the facets.
void require_engines(const Case& given) {
    const SegmentLists lists = lamella::baselines::trivial_slicing.slice(given.problem);
    for (const ContourMethod* method : lamella::baselines::contour_methods) {
        INFO(method->name);
        const bool closed = given.result.info.open_contours == 0;
        agreement::require_same(method->join(lists), given.result, method == &trivial_contours && closed);
    }
}

using Sides = std::multiset<std::pair<Point, Point>>;

/// Those whose ends differ.
Sides sides_of(const std::vector<Polyline>& polylines) {
    Sides sides;
    for (const auto& [points, closed] : polylines) {
        for (std::size_t i = closed ? 0 : 1; i < points.size(); ++i) {
            const Point from = points[i > 0 ? i - 1 : points.size() - 1];
            if (from != points[i]) {
                sides.insert(std::minmax(from, points[i]));
            }
        }
    }
    return sides;
}

std::vector<Polyline> each_alone(const std::vector<lamella::baselines::Segment>& segments) {
    std::vector<Polyline> polylines;
    polylines.reserve(segments.size());
    for (const auto& [from, to] : segments) {
        polylines.push_back({{from, to}, false});
    }
    return polylines;
}

/// A lower bound for the number of open polylines: half the number of points in which an odd number of segments meet.
std::ptrdiff_t fewest_open(const Sides& sides) {
    std::map<Point, int> met;
    for (const auto& [a, b] : sides) {
        ++met[a];
        ++met[b];
    }
    return std::count_if(met.begin(), met.end(), [](const auto& entry) { return entry.second % 2 == 1; }) / 2;
}

std::ptrdiff_t open_of(const std::vector<Polyline>& polylines) {
    return std::count_if(polylines.begin(), polylines.end(), [](const Polyline& p) { return !p.closed; });
}

using RoleAndLine = std::pair<Role, agreement::Line>;

std::vector<RoleAndLine> with_roles(const std::vector<Polyline>& plane, const std::vector<Role>& roles) {
    std::vector<RoleAndLine> lines;
    lines.reserve(plane.size());
    for (std::size_t c = 0; c < plane.size(); ++c) {
        lines.emplace_back(roles[c], agreement::canonical(plane[c].points, plane[c].closed, plane[c].closed));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

void require_engines_roles(const Case& given) {
    Contours contours = hashed_contours.join(lamella::baselines::trivial_slicing.slice(given.problem));
    const lamella::baselines::Roles found = sense_by_rays(contours);
    for (std::size_t i = 0; i < contours.size(); ++i) {
        std::vector<Polyline> plane;
        std::vector<Role> roles;
        for (const lamella::Contour& contour : given.result.contours_of(given.result.layers[i])) {
            const auto points = given.result.points_of(contour);
            plane.push_back({{points.begin(), points.end()}, contour.role != Role::open});
            roles.push_back(contour.role);
        }
        INFO("plane " << i);
        REQUIRE((with_roles(contours[i], found[i]) == with_roles(plane, roles)));
    }
}

Polyline ring(std::vector<Point> points) {
    return {std::move(points), true};
}

}  // namespace

TEST_CASE("baselines join segments into the engine's contours", "[baselines]") {
    for (const Shape shape : {Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism}) {
        const std::vector<float> soup = agreement::from_recipe(shape, 3000);
        require_engines(Case(soup, uniform(0.25)));
        require_engines(Case(soup, {}, agreement::irregular(0.1, 0.9)));
    }
    const Case open(agreement::with_gaps(shapes::floats(agreement::nested_balls()), 7), uniform(0.3));
    REQUIRE(open.result.info.open_contours > 0);
    require_engines(open);
}

TEST_CASE("every segment is used once where any number of them meet", "[baselines]") {
    lamella::SliceOptions options = at_heights({0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5});
    options.frame.grid_mm = 0.125;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed " << seed);
        const Case given(
            shapes::floats(seed % 2 == 0 ? shapes::random_soup(seed, 40, 5) : shapes::random_tetrahedra(seed, 12, 5)),
            options);
        const SegmentLists lists = lamella::baselines::trivial_slicing.slice(given.problem);
        const Contours trivial = trivial_contours.join(lists);
        const Contours hashed = hashed_contours.join(lists);
        for (std::size_t i = 0; i < lists.size(); ++i) {
            INFO("plane " << i);
            const Sides sides = sides_of(each_alone(lists[i]));
            REQUIRE((sides_of(trivial[i]) == sides));
            REQUIRE((sides_of(hashed[i]) == sides));
            CHECK(open_of(trivial[i]) >= fewest_open(sides));
            CHECK(open_of(hashed[i]) == fewest_open(sides));
        }
    }
}

TEST_CASE("a contour of two segments closes, and segments of no length are dropped", "[baselines]") {
    const SegmentLists lists{
        {{{0, 0}, {4, 0}}, {{4, 0}, {0, 0}}, {{4, 0}, {4, 0}}, {{9, 9}, {9, 9}}}, {}, {{{1, 1}, {2, 2}}}};
    for (const ContourMethod* method : {&trivial_contours, &hashed_contours}) {
        INFO(method->name);
        const Contours contours = method->join(lists);
        CHECK((agreement::lines_of(contours[0], false) == std::vector<agreement::Line>{{true, {{0, 0}, {4, 0}}}}));
        CHECK(contours[1].empty());
        CHECK((agreement::lines_of(contours[2], false) == std::vector<agreement::Line>{{false, {{1, 1}, {2, 2}}}}));
    }
}

TEST_CASE("joining thousands of segments in one point takes no longer than joining others", "[baselines]") {
    constexpr std::int32_t spokes = 200'000;
    SegmentLists lists(1);
    for (std::int32_t i = 0; i < spokes; ++i) {
        lists[0].push_back({{0, 0}, {i + 1, 7}});
        lists[0].push_back({{i + 1, 7}, {0, 0}});
    }
    const Contours contours = hashed_contours.join(lists);
    CHECK(open_of(contours[0]) == 0);
    CHECK(sides_of(contours[0]).size() == 2 * spokes);
}

#ifdef LAMELLA_BASELINES_CGAL
TEST_CASE("a sweep line splits segments at crossings and keeps all their ends", "[baselines]") {
    const SegmentLists cross{{{{0, 0}, {4, 4}}, {{0, 4}, {4, 0}}}};
    const Contours contours = lamella::baselines::sweepline_contours.join(cross);
    CHECK(open_of(contours[0]) == 2);
    CHECK((sides_of(contours[0]) == Sides{{{0, 0}, {2, 2}}, {{0, 4}, {2, 2}}, {{2, 2}, {4, 0}}, {{2, 2}, {4, 4}}}));
}
#endif

TEST_CASE("rays find the engine's roles and orientations", "[baselines]") {
    for (const Shape shape : {Shape::gyroid, Shape::bone, Shape::torus}) {
        require_engines_roles(Case(agreement::from_recipe(shape, 3000), uniform(0.25)));
    }
    require_engines_roles(Case(shapes::floats(agreement::nested_balls()), {}, agreement::irregular(0.05, 0.3)));
    require_engines_roles(Case(shapes::floats(shapes::box({0, 0, 0}, {3, 3, 3})), uniform(0.1)));
}

TEST_CASE("rays find roles where contours touch, and none for open and flat contours", "[baselines]") {
    constexpr std::int32_t far = lamella::grid_limit;
    const Polyline half = ring({{-far, -far}, {far, -far}, {far, far}});
    Contours contours{
        {
            ring({{0, 0}, {0, 8}, {8, 8}, {8, 0}}),  // clockwise: will be reversed
            ring({{0, 4}, {2, 2}, {4, 4}, {2, 6}}),  // its first point lies on the contour around it
            ring({{4, 4}, {6, 2}, {8, 4}, {6, 6}}),  // touches both
            ring({{5, 4}, {6, 5}, {7, 4}, {6, 3}}),  // outer, within a hole
            ring({{20, 0}, {24, 0}, {22, 0}}),       // flat
            Polyline{{{-1, 1}, {9, 1}}, false},      // open, crossed by rays
            ring({{8, 8}, {8, 9}, {9, 9}}),          // touches the first contour at a corner, from outside
        },
        {ring({{0, 0}, {8, 0}, {4, 8}}), ring({{4, 8}, {3, 3}, {5, 3}})},          // a hole starts at the top of its outer
        {ring({{0, 0}, {8, 0}, {8, 8}, {0, 8}}), ring({{4, 8}, {3, 3}, {5, 3}})},  // or on its upper side
        {Polyline{{{0, 0}, {8, 0}, {8, 8}, {0, 8}}, false}, ring({{3, 3}, {5, 3}, {4, 4}})},
        {half, ring({{-1, 0}, {-far, far}, {-2, 1}})},  // starts one unit outside the long side, at the limits of the grid
        {half, ring({{1, 0}, {3, 0}, {3, 1}})},         // and one unit inside
    };
    constexpr Role outer = Role::outer;
    constexpr Role hole = Role::hole;
    CHECK((sense_by_rays(contours) == lamella::baselines::Roles{{outer, hole, hole, outer, Role::flat, Role::open, outer},
                                                                {outer, hole},
                                                                {outer, hole},
                                                                {Role::open, outer},
                                                                {outer, outer},
                                                                {outer, hole}}));
    CHECK((contours[0][0].points == std::vector<Point>{{8, 0}, {8, 8}, {0, 8}, {0, 0}}));
    CHECK((contours[0][4].points == std::vector<Point>{{20, 0}, {24, 0}, {22, 0}}));
}
