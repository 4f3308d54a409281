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
using lamella::baselines::Segment;
using lamella::baselines::SegmentLists;
using lamella::baselines::trivial_contours;

namespace {

void require_engines(const Case& given) {
    const SegmentLists lists = lamella::baselines::trivial_slicing.slice(given.problem);
    for (const ContourMethod* method : lamella::baselines::contour_methods) {
        INFO(method->name);
        agreement::require_same(method->join(lists), given.result, false);
    }
}

using PlaneSide = std::pair<Point, Point>;

PlaneSide side(Point a, Point b) {
    return std::minmax(a, b);
}

std::multiset<PlaneSide> sides_of(const std::vector<Polyline>& polylines) {
    std::multiset<PlaneSide> sides;
    for (const Polyline& polyline : polylines) {
        for (std::size_t i = 1; i < polyline.points.size(); ++i) {
            sides.insert(side(polyline.points[i - 1], polyline.points[i]));
        }
        if (polyline.closed) {
            sides.insert(side(polyline.points.back(), polyline.points.front()));
        }
    }
    return sides;
}

/// The segments whose ends differ.
std::multiset<PlaneSide> sides_of(const std::vector<Segment>& segments) {
    std::multiset<PlaneSide> sides;
    for (const auto& [from, to] : segments) {
        if (from != to) {
            sides.insert(side(from, to));
        }
    }
    return sides;
}

/// A lower bound for the number of open polylines: half the number of points in which an odd number of segments meet.
std::ptrdiff_t fewest_open(const std::multiset<PlaneSide>& sides) {
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

Case coarse(const shapes::Soup& soup) {
    lamella::SliceOptions options = at_heights({0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5});
    options.frame.grid_mm = 0.125;
    return {shapes::floats(soup), options};
}

using RoleAndLine = std::pair<Role, agreement::Line>;

std::vector<RoleAndLine> with_roles(const std::vector<Polyline>& plane, const std::vector<Role>& roles) {
    std::vector<RoleAndLine> lines;
    for (std::size_t c = 0; c < plane.size(); ++c) {
        lines.emplace_back(roles[c], agreement::canonical(plane[c].points, plane[c].closed, roles[c] != Role::open));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

std::vector<RoleAndLine> with_roles(const lamella::SliceResult& result, const lamella::Layer& layer) {
    std::vector<RoleAndLine> lines;
    for (const lamella::Contour& contour : result.contours_of(layer)) {
        const auto points = result.points_of(contour);
        const bool open = contour.role == Role::open;
        lines.emplace_back(contour.role, agreement::canonical({points.begin(), points.end()}, !open, !open));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

void require_engines_roles(const Case& given) {
    Contours contours = hashed_contours.join(lamella::baselines::trivial_slicing.slice(given.problem));
    const lamella::baselines::Roles roles = sense_by_rays(contours);
    REQUIRE(roles.size() == contours.size());
    for (std::size_t i = 0; i < contours.size(); ++i) {
        INFO("plane " << i);
        REQUIRE((with_roles(contours[i], roles[i]) == with_roles(given.result, given.result.layers[i])));
    }
}

Polyline ring(std::vector<Point> points) {
    return {std::move(points), true};
}

}  // namespace

TEST_CASE("baselines join closed meshes into the engine's contours", "[baselines]") {
    using lamella::models::Shape;
    const Shape shape = GENERATE(Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism);
    const std::vector<float> soup = agreement::from_recipe(shape, 3000);
    require_engines(Case(soup, uniform(0.25)));
    require_engines(Case(soup, {}, agreement::irregular(0.1, 0.9)));
}

TEST_CASE("baselines join open meshes into the engine's polylines", "[baselines]") {
    const Case given(agreement::with_gaps(shapes::floats(agreement::nested_balls()), 7), uniform(0.3));
    REQUIRE(given.result.info.open_contours > 0);
    require_engines(given);
}

TEST_CASE("the trivial method keeps the orientation of the facets", "[baselines]") {
    const Case given(agreement::from_recipe(lamella::models::Shape::gyroid, 3000), uniform(0.25));
    agreement::require_same(trivial_contours.join(lamella::baselines::trivial_slicing.slice(given.problem)), given.result,
                            true);
}

TEST_CASE("every segment is used once where any number of them meet", "[baselines]") {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        INFO("seed " << seed);
        const Case given = coarse(seed % 2 == 0 ? shapes::random_soup(seed, 40, 5) : shapes::random_tetrahedra(seed, 12, 5));
        const SegmentLists lists = lamella::baselines::trivial_slicing.slice(given.problem);
        const Contours trivial = trivial_contours.join(lists);
        const Contours hashed = hashed_contours.join(lists);
        for (std::size_t i = 0; i < lists.size(); ++i) {
            INFO("plane " << i);
            const std::multiset<PlaneSide> sides = sides_of(lists[i]);
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
        REQUIRE(contours.size() == 3);
        REQUIRE(contours[0].size() == 1);
        CHECK(contours[0][0].closed);
        CHECK(contours[0][0].points.size() == 2);
        CHECK(contours[1].empty());
        REQUIRE(contours[2].size() == 1);
        CHECK_FALSE(contours[2][0].closed);
        CHECK(contours[2][0].points.size() == 2);
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
    CHECK((sides_of(contours[0]) ==
           std::multiset<PlaneSide>{{{0, 0}, {2, 2}}, {{0, 4}, {2, 2}}, {{2, 2}, {4, 0}}, {{2, 2}, {4, 4}}}));
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        INFO("seed " << seed);
        const Case given = coarse(shapes::random_soup(seed, 40, 5));
        const SegmentLists lists = lamella::baselines::trivial_slicing.slice(given.problem);
        const Contours swept = lamella::baselines::sweepline_contours.join(lists);
        for (std::size_t i = 0; i < lists.size(); ++i) {
            std::set<Point> points;
            for (const Polyline& polyline : swept[i]) {
                points.insert(polyline.points.begin(), polyline.points.end());
            }
            for (const auto& [a, b] : sides_of(lists[i])) {
                CHECK(points.count(a) + points.count(b) == 2);
            }
        }
    }
}
#endif

TEST_CASE("rays find the engine's roles and orientations", "[baselines]") {
    using lamella::models::Shape;
    for (const Shape shape : {Shape::gyroid, Shape::bone, Shape::torus}) {
        require_engines_roles(Case(agreement::from_recipe(shape, 3000), uniform(0.25)));
    }
    require_engines_roles(Case(shapes::floats(agreement::nested_balls()), {}, agreement::irregular(0.05, 0.3)));
    require_engines_roles(Case(shapes::floats(shapes::box({0, 0, 0}, {3, 3, 3})), uniform(0.1)));
}

TEST_CASE("rays find roles where contours touch, and none for open and flat contours", "[baselines]") {
    Contours contours{{
        ring({{0, 0}, {0, 8}, {8, 8}, {8, 0}}),  // clockwise: will be reversed
        ring({{0, 4}, {2, 2}, {4, 4}, {2, 6}}),  // its first point lies on the contour around it
        ring({{4, 4}, {6, 2}, {8, 4}, {6, 6}}),  // touches both
        ring({{5, 4}, {6, 5}, {7, 4}, {6, 3}}),  // outer, within a hole
        ring({{20, 0}, {24, 0}, {22, 0}}),       // flat
        Polyline{{{-1, 1}, {9, 1}}, false},      // open, crossed by rays
        ring({{8, 8}, {8, 9}, {9, 9}}),          // touches the first contour at a corner, from outside
    }};
    const lamella::baselines::Roles roles = sense_by_rays(contours);
    CHECK((roles[0] ==
           std::vector<Role>{Role::outer, Role::hole, Role::hole, Role::outer, Role::flat, Role::open, Role::outer}));
    CHECK((contours[0][0].points == std::vector<Point>{{8, 0}, {8, 8}, {0, 8}, {0, 0}}));
    CHECK((contours[0][4].points == std::vector<Point>{{20, 0}, {24, 0}, {22, 0}}));
}

TEST_CASE("a hole may start at the top of its outer contour, and open polylines enclose nothing", "[baselines]") {
    Contours contours{{ring({{0, 0}, {8, 0}, {4, 8}}), ring({{4, 8}, {3, 3}, {5, 3}})},
                      {ring({{0, 0}, {8, 0}, {8, 8}, {0, 8}}), ring({{4, 8}, {3, 3}, {5, 3}})},
                      {Polyline{{{0, 0}, {8, 0}, {8, 8}, {0, 8}}, false}, ring({{3, 3}, {5, 3}, {4, 4}})}};
    const lamella::baselines::Roles roles = sense_by_rays(contours);
    CHECK((roles[0] == std::vector<Role>{Role::outer, Role::hole}));
    CHECK((roles[1] == std::vector<Role>{Role::outer, Role::hole}));
    CHECK((roles[2] == std::vector<Role>{Role::open, Role::outer}));
}

TEST_CASE("rays are exact at the limits of the grid", "[baselines]") {
    constexpr std::int32_t far = lamella::grid_limit;
    // The second contour starts one unit from the long side of the first: outside, then inside.
    Contours contours{{ring({{-far, -far}, {far, -far}, {far, far}}), ring({{-1, 0}, {-far, far}, {-2, 1}})},
                      {ring({{-far, -far}, {far, -far}, {far, far}}), ring({{1, 0}, {3, 0}, {3, 1}})}};
    const lamella::baselines::Roles roles = sense_by_rays(contours);
    CHECK((roles[0] == std::vector<Role>{Role::outer, Role::outer}));
    CHECK((roles[1] == std::vector<Role>{Role::outer, Role::hole}));
}
