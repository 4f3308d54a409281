// Baselines that slice and join in their own way, compared with the engine.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "baselines/agreement.hpp"
#include "ldni.hpp"
#include "mcmains.hpp"
#include "slic3r_way.hpp"
#include "topological.hpp"

using agreement::Case;
using lamella::Contour;
using lamella::Layer;
using lamella::LayerPlan;
using lamella::Point;
using lamella::SliceResult;
using lamella::UniformLayers;
using lamella::baselines::ldni;
using lamella::baselines::ldni_resolution_mm;
using lamella::baselines::mcmains;
using lamella::baselines::Polyline;
using lamella::baselines::Problem;
using lamella::baselines::slic3r_way;
using lamella::baselines::topological;
using lamella::baselines::WholeMethod;
using lamella::baselines::WholeOutcome;

namespace {

using Points = std::vector<Point>;

/// Drops equal successive points and rotates to the smallest rotation. With `any_orientation`, also considers the reversed
/// points.
agreement::Line canonical(Points points, bool closed, bool any_orientation) {
    points.erase(std::unique(points.begin(), points.end()), points.end());
    while (closed && points.size() > 1 && points.front() == points.back()) {
        points.pop_back();
    }
    return agreement::canonical(std::move(points), closed, !any_orientation);
}

using Canonical = std::vector<agreement::Line>;  // the sorted contours of one plane

Canonical canonical(const std::vector<Polyline>& contours, bool any_orientation = false) {
    Canonical all;
    for (const Polyline& contour : contours) {
        all.push_back(canonical(contour.points, contour.closed, any_orientation));
    }
    std::sort(all.begin(), all.end());
    return all;
}

/// The engine's contours, with the orientation of the facets.
Canonical canonical(const SliceResult& result, const Layer& layer, bool any_orientation = false) {
    std::vector<Polyline> contours;
    for (const Contour& contour : result.contours_of(layer)) {
        const auto points = result.points_of(contour);
        Polyline& polyline = contours.emplace_back();
        polyline.closed = contour.role != lamella::Role::open;
        polyline.points.assign(points.begin(), points.end());
        if (contour.orientation ==
            (contour.role == lamella::Role::outer ? -1 : 1)) {  // the engine reversed it to fit its role
            std::reverse(polyline.points.begin(), polyline.points.end());
        }
    }
    return canonical(contours, any_orientation);
}

lamella::SliceOptions options_of(const LayerPlan& plan, double unit_mm = 0) {
    lamella::SliceOptions options;
    options.plan = plan;
    options.unit_mm = unit_mm;
    options.control.threads = 1;
    return options;
}

const WholeMethod* const exact_methods[] = {&slic3r_way, &mcmains, &topological};

void check_equal(const Case& expected, const WholeMethod& method, bool any_orientation = false) {
    INFO(method.name);
    const WholeOutcome outcome = method.run(expected.problem);
    REQUIRE(outcome.contours.size() == expected.result.layers.size());
    CHECK(outcome.segments == expected.result.summary.segments);
    for (std::size_t i = 0; i < outcome.contours.size(); ++i) {
        INFO("layer " << i);
        REQUIRE(canonical(outcome.contours[i], any_orientation) ==
                canonical(expected.result, expected.result.layers[i], any_orientation));
    }
}

std::vector<LayerPlan> plans(double height_mm) {
    const double from = height_mm / 50;
    return {LayerPlan{UniformLayers{height_mm / 30}},
            LayerPlan{lamella::RandomLayers{.min_height_mm = from, .max_height_mm = 4 * from}},
            LayerPlan{
                lamella::ExplicitPlanes{{-height_mm, 0.11 * height_mm, 0.111 * height_mm, 0.5 * height_mm, 2 * height_mm}}}};
}

shapes::Soup without_first_facets(shapes::Soup soup, std::ptrdiff_t count) {
    soup.erase(soup.begin(), soup.begin() + 9 * count);
    return soup;
}

}  // namespace

TEST_CASE("Slic3r, McMains and the topological method give the engine's contours of sample meshes", "[baselines]") {
    using lamella::models::Shape;
    for (const auto& [shape, triangles] : {std::pair(Shape::sphere, 2'000), std::pair(Shape::torus, 3'000),
                                           std::pair(Shape::gyroid, 8'000), std::pair(Shape::bone, 12'000)}) {
        const std::vector<float> soup = agreement::from_recipe(shape, static_cast<std::uint64_t>(triangles));
        for (const LayerPlan& plan : plans(20)) {
            const Case expected(soup, options_of(plan));
            for (const WholeMethod* method : exact_methods) {
                check_equal(expected, *method);
            }
        }
    }
}

TEST_CASE("whole methods pair facets at an edge of more than two as the engine does", "[baselines]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {4, 4, 4});
    std::vector<shapes::Soup> soups{cube, shapes::joined({cube, cube, cube}),
                                    shapes::joined({cube, shapes::box({4, 4, 0}, {8, 8, 4})}),
                                    shapes::joined({shapes::box({0, 0, 0}, {8, 8, 8}), shapes::flipped(cube)})};
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        soups.push_back(shapes::random_tetrahedra(seed, 12, 6));
    }
    for (const shapes::Soup& soup : soups) {
        const std::vector<float> numbers = shapes::floats(soup);
        const Case expected(numbers, options_of(LayerPlan{UniformLayers{0.5}}, coarse_unit_mm / 8));
        for (const WholeMethod* method : exact_methods) {
            check_equal(expected, *method);
        }
    }
}

TEST_CASE("for an open mesh Slic3r's method gives the engine's polylines, and the others none", "[baselines]") {
    std::vector<shapes::Soup> soups{without_first_facets(shapes::octasphere({0, 0, 0}, 5, 3), 100),
                                    shapes::triangle({0, 0, 0}, {4, 0, 4}, {0, 3, 2})};
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        soups.push_back(shapes::random_soup(seed, 30, 6));
    }
    for (const shapes::Soup& soup : soups) {
        const std::vector<float> numbers = shapes::floats(soup);
        const Case expected(numbers, options_of(LayerPlan{UniformLayers{0.5}}, coarse_unit_mm / 8));
        check_equal(expected, slic3r_way, true);
        for (const WholeMethod* method : {&mcmains, &topological}) {
            CHECK_FALSE(method->takes_open_meshes);
            const WholeOutcome outcome = method->run(expected.problem);
            CHECK(outcome.contours.size() == expected.problem.planes.size());
            CHECK(std::ranges::all_of(outcome.contours, [](const auto& contours) { return contours.empty(); }));
        }
        CHECK(ldni.run(expected.problem).contours.size() == expected.problem.planes.size());
    }
}

TEST_CASE("whole methods accept a soup without facets and a problem without planes", "[baselines]") {
    const std::vector<float> flat{0, 0, 0, 0, 0, 0, 1, 1, 1};
    const std::vector<float> cube = shapes::floats(shapes::box({0, 0, 0}, {4, 4, 4}));
    for (const WholeMethod* method : {&slic3r_way, &mcmains, &topological, &ldni}) {
        INFO(method->name);
        const WholeOutcome nothing = method->run({.soup = flat, .planes = {1, 3}});
        CHECK(nothing.segments == 0);
        REQUIRE(nothing.contours.size() == 2);
        CHECK(nothing.contours[0].empty());
        CHECK(method->run({.soup = cube, .planes = {}}).contours.empty());
    }
}

TEST_CASE("layers sampled by rays have the engine's areas within the resolution", "[baselines]") {
    using lamella::models::Shape;
    for (const Shape shape : {Shape::sphere, Shape::torus, Shape::gyroid, Shape::bone, Shape::prism}) {
        const std::vector<float> soup = agreement::from_recipe(shape, 12'000);
        for (const LayerPlan& plan : plans(20)) {
            const Case expected(soup, options_of(plan));
            const WholeOutcome outcome = ldni.run(expected.problem);
            REQUIRE(outcome.contours.size() == expected.result.layers.size());
            for (std::size_t i = 0; i < outcome.contours.size(); ++i) {
                double difference = 0;
                double border = 0;
                for (const auto& [closed, points] : canonical(expected.result, expected.result.layers[i])) {
                    difference -= static_cast<double>(rings::twice_area(points)) / 2;
                    border += static_cast<double>(rings::perimeter(points));
                }
                for (const Polyline& contour : outcome.contours[i]) {
                    CHECK(contour.closed);
                    difference += static_cast<double>(rings::twice_area(contour.points)) / 2;
                }
                INFO("layer " << i);
                CHECK(std::abs(difference) <= border * ldni_resolution_mm / expected.result.unit_mm);
            }
        }
    }
}
