// The algorithms that the paper describes or compares find the oracle's segments and the engine's contours.
#include <cstring>
#include <functional>

#include "engine/slicing.hpp"
#include "geometry.hpp"
#include "methods.hpp"
#include "models/models.hpp"
#include "oracle/oracle.hpp"
#include "rings.hpp"
#include "slicing/tuning.hpp"

namespace lamella::baselines::test {

namespace {

using models::Shape;
using shapes::Soup;

/// The engine's result, and the problem with the same planes.
struct Case {
    Case(std::vector<float> triangles, const SliceOptions& options, const Tuning& tuning = {})
        : soup(std::move(triangles)), result(sliced(MeshView::soup(std::span<const float>(soup)), options, {}, tuning)) {
        const SliceOptions& done = result.info.options;
        problem.soup = soup;
        problem.unit_mm = result.info.grid_mm;
        for (const Layer& layer : result.layers) {
            problem.planes.push_back(layer.plane.z());
        }
        if (!done.heights_mm && !problem.planes.empty()) {
            problem.uniform = true;
            problem.step = done.layer_height_mm / result.info.grid_mm;
            problem.first = result.layers[0].plane_mm / result.info.grid_mm - 1;
        }
    }
    Case(const Soup& doubles, const SliceOptions& options, const Tuning& tuning = {})
        : Case(shapes::floats(doubles), options, tuning) {}
    Case(const Case&) = delete;
    Case& operator=(const Case&) = delete;

    bool is_open() const { return result.info.open_contours > 0; }

    std::vector<float> soup;
    SliceResult result;
    Problem problem;
};
using Take = std::function<void(const Case&)>;

/// Random layers.
Tuning irregular(double least_mm, double most_mm) {
    return {.random_heights = RandomHeights{least_mm, most_mm, 7}};
}

/// A ball, an inverted ball inside it, and a ball inside that: an outer contour, its hole, and an outer contour in the hole.
Soup nested_balls() {
    return shapes::joined({shapes::octasphere({0, 0, 0}, 10, 3), shapes::flipped(shapes::octasphere({1, 0, 0}, 8, 3)),
                           shapes::octasphere({2, 0, 1}, 5, 3)});
}

/// Removes every seventh triangle.
Soup with_gaps(const Soup& soup) {
    Soup rest;
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        shapes::append(rest, t % 7 != 0 ? shapes::only(soup, t, 1) : Soup());
    }
    return rest;
}

/// Generated meshes of 20 mm at uniform, random and listed heights.
void each_model(std::uint64_t triangles, const Take& take) {
    for (const Shape shape : {Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism}) {
        const std::vector<float> soup =
            models::make_soup({.shape = shape, .triangles = triangles, .height_mm = 20, .order = models::Order::random});
        INFO(models::shape_names[static_cast<std::size_t>(shape)]);
        take({soup, uniform(0.25)});
        take({soup, uniform(0.667)});
        take({soup, {}, irregular(0.1, 0.9)});
        take({soup, at_heights({-20, 2.2, 2.22, 10, 40}, 0)});
    }
}

/// Meshes in whose planes points and edges coincide, or whose triangles collapse on the grid: closed ones, and open ones.
void each_tangle(const Take& take) {
    const Soup cube = shapes::box({0, 0, 0}, {4, 4, 4});
    std::vector<Soup> soups{cube,
                            shapes::joined({cube, cube, cube}),
                            shapes::joined({cube, shapes::box({4, 4, 0}, {8, 8, 4})}),
                            shapes::joined({shapes::box({0, 0, 0}, {8, 8, 8}), shapes::flipped(cube)}),
                            shapes::without(shapes::octasphere({0, 0, 0}, 5, 3), 0, 100),
                            shapes::triangle({0, 0, 0}, {4, 0, 4}, {0, 3, 2})};
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        soups.push_back(shapes::random_tetrahedra(seed, 12, 6));
        soups.push_back(shapes::random_soup(seed, 30, 6));
    }
    for (const Soup& soup : soups) {
        INFO("tangle " << &soup - soups.data());
        take({soup, uniform(0.5, coarse_unit_mm / 8)});
    }
    for (const double unit_mm : {0.5, 0.037}) {
        take({shapes::octasphere({0.3, 0, 0.1}, 4, 5), uniform(3.1 * unit_mm, unit_mm)});
    }
    // Planes below, above and between all triangles.
    take({shapes::joined({shapes::box({0, 0, 0}, {1, 1, 1}), shapes::box({0, 0, 4}, {1, 1, 5})}),
          at_heights({-3, -2, 0.5, 2, 3, 4.5, 6, 7}, 0)});
}

/// Meshes with open contours.
void each_open(const Take& take) {
    for (const Soup& soup : {with_gaps(nested_balls()), with_gaps(shapes::octasphere({0, 0, 0}, 5, 4))}) {
        take({soup, uniform(0.3)});
        take({soup, {}, irregular(0.1, 0.6)});
    }
}

template <class Segments>
std::vector<std::pair<Point, Point>> in_order(const Segments& segments) {
    std::vector<std::pair<Point, Point>> ends;
    ends.reserve(segments.size());
    for (const auto& segment : segments) {
        ends.emplace_back(segment.from, segment.to);
    }
    std::sort(ends.begin(), ends.end());
    return ends;
}

/// Triangles by ascending lowest vertex.
std::vector<float> presorted(const std::vector<float>& soup) {
    std::vector<std::array<float, 9>> triangles(soup.size() / 9);
    std::memcpy(triangles.data(), soup.data(), soup.size() * sizeof(float));
    std::ranges::stable_sort(triangles, {}, [](const auto& t) { return std::min({t[2], t[5], t[8]}); });
    std::vector<float> sorted(soup.size());
    std::memcpy(sorted.data(), triangles.data(), soup.size() * sizeof(float));
    return sorted;
}

void require_oracles_segments(const Case& given) {
    const std::vector<oracle::Triangle> triangles =
        oracle::quantise(Soup(given.soup.begin(), given.soup.end()), given.problem.unit_mm);
    const std::vector<float> sorted = presorted(given.soup);
    for (const SlicingMethod* method : slicing_methods) {
        if (!given.problem.uniform && method->uniform_only) {
            continue;
        }
        INFO(method->name);
        Problem problem = given.problem;
        problem.soup = method == &presorted_slicing ? sorted : given.soup;
        const SegmentLists lists = method->slice(problem);
        REQUIRE(lists.size() == problem.planes.size());
        for (std::size_t i = 0; i < lists.size(); ++i) {
            INFO("plane " << i);
            REQUIRE((in_order(lists[i]) == in_order(oracle::segments_at(triangles, problem.planes[i]))));
        }
    }
}

using Line = std::pair<bool, std::vector<Point>>;  ///< whether it is closed, and its points

/// Without equal successive points. A closed contour starts at its smallest point. If not `directed`, the smaller of the two
/// directions is taken.
Line canonical(std::vector<Point> points, bool closed, bool directed) {
    points.erase(std::unique(points.begin(), points.end()), points.end());
    while (closed && points.size() > 1 && points.front() == points.back()) {
        points.pop_back();
    }
    std::vector<Point> back(points.rbegin(), points.rend());
    if (closed) {
        points = rings::from_smallest(points);
        back = rings::from_smallest(back);
    }
    return {closed, directed ? points : std::min(points, back)};
}

std::vector<Line> lines_of(const std::vector<Polyline>& plane, bool directed) {
    std::vector<Line> lines;
    lines.reserve(plane.size());
    for (const Polyline& polyline : plane) {
        lines.push_back(canonical(polyline.points, polyline.closed, directed));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

/// The engine's contours; `as_sliced` with the orientation of the facets, else with that of their roles.
std::vector<Polyline> engines(const SliceResult& result, std::size_t plane, bool as_sliced) {
    std::vector<Polyline> contours;
    for (const Contour& contour : result.contours_of(result.layers[plane])) {
        const auto points = result.points_of(contour);
        contours.push_back({{points.begin(), points.end()}, contour.role != Role::open});
        if (as_sliced && contour.orientation == (contour.role == Role::outer ? -1 : 1)) {  // reversed to fit its role
            std::reverse(contours.back().points.begin(), contours.back().points.end());
        }
    }
    return contours;
}

void require_engines(const Contours& contours, const Case& given, bool directed) {
    REQUIRE(contours.size() == given.result.layers.size());
    for (std::size_t i = 0; i < contours.size(); ++i) {
        INFO("plane " << i);
        REQUIRE((lines_of(contours[i], directed) == lines_of(engines(given.result, i, true), directed)));
    }
}

/// Only the trivial method keeps the orientation of the facets.
void require_joined(const Case& given) {
    const SegmentLists lists = trivial_slicing.slice(given.problem);
    for (const ContourMethod* method : contour_methods) {
        INFO(method->name);
        require_engines(method->join(lists), given, method == &trivial_contours && !given.is_open());
    }
}

/// Methods of closed meshes give nothing for others.
void require_whole(const Case& given) {
    const CheckOptions counts{.frame = {.grid_mm = given.problem.unit_mm}, .counts_only = true};
    const bool closed = value_of(check(MeshView::soup(given.problem.soup), counts)).closed;
    for (const WholeMethod* method : {&slic3r_way, &mcmains, &topological}) {
        INFO(method->name);
        const WholeOutcome outcome = method->run(given.problem);
        CHECK(outcome.segments == (closed || method == &slic3r_way ? given.result.info.segments : 0));
        if (closed) {
            require_engines(outcome.contours, given, true);
        } else if (method != &slic3r_way) {
            CHECK(outcome.contours.size() == given.problem.planes.size());
            CHECK(std::ranges::all_of(outcome.contours, [](const auto& plane) { return plane.empty(); }));
        }
    }
}

using RoleAndLine = std::pair<Role, Line>;

std::vector<RoleAndLine> with_roles(const std::vector<Polyline>& plane, const std::vector<Role>& roles) {
    std::vector<RoleAndLine> lines;
    lines.reserve(plane.size());
    for (std::size_t c = 0; c < plane.size(); ++c) {
        lines.emplace_back(roles[c], canonical(plane[c].points, plane[c].closed, plane[c].closed));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
}

void require_engines_roles(const Case& given) {
    Contours contours = hashed_contours.join(trivial_slicing.slice(given.problem));
    const Roles found = sense_by_rays(contours);
    for (std::size_t i = 0; i < contours.size(); ++i) {
        std::vector<Role> roles;
        roles.reserve(contours[i].size());
        for (const Contour& contour : given.result.contours_of(given.result.layers[i])) {
            roles.push_back(contour.role);
        }
        INFO("plane " << i);
        REQUIRE((with_roles(contours[i], found[i]) == with_roles(engines(given.result, i, false), roles)));
    }
}

}  // namespace

TEST_CASE("baselines cut meshes into the oracle's segments", "[baselines]") {
    each_model(1500, require_oracles_segments);
    each_tangle(require_oracles_segments);
    each_open(require_oracles_segments);
}

TEST_CASE("baselines join segments into the engine's contours", "[baselines]") {
    each_model(3000, require_joined);
    each_open([](const Case& given) {
        REQUIRE(given.is_open());
        require_joined(given);
    });
}

TEST_CASE("whole methods give the engine's contours, and pair facets at an edge of more than two as it does",
          "[baselines]") {
    each_model(8000, require_whole);
    each_tangle(require_whole);
    each_open(require_whole);
}

TEST_CASE("rays find the engine's roles and orientations", "[baselines]") {
    each_model(3000, require_engines_roles);
    require_engines_roles({nested_balls(), {}, irregular(0.05, 0.3)});
}

}  // namespace lamella::baselines::test
