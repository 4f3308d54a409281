// Baselines that slice and join in their own way, compared with the engine.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "baselines/agreement.hpp"
#include "methods.hpp"

using agreement::Case;
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

const WholeMethod* const exact_methods[] = {&slic3r_way, &mcmains, &topological};

void check_equal(const Case& expected, const WholeMethod& method, bool any_orientation = false) {
    INFO(method.name);
    const WholeOutcome outcome = method.run(expected.problem);
    CHECK(outcome.segments == expected.result.info.segments);
    agreement::require_same(outcome.contours, expected.result, !any_orientation);
}

/// Calls take(case) for a mesh of that height, cut at uniform layers, at random and at listed heights.
template <class Take>
void each_plan(const std::vector<float>& soup, double height_mm, const Take& take) {
    take(Case(soup, uniform(height_mm / 30)));
    take(Case(soup, {}, agreement::irregular(height_mm / 50, 4 * height_mm / 50)));
    lamella::SliceOptions listed;
    listed.heights_mm = {{-height_mm, 0.11 * height_mm, 0.111 * height_mm, 0.5 * height_mm, 2 * height_mm}};
    take(Case(soup, listed));
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
        each_plan(soup, 20, [](const Case& expected) {
            for (const WholeMethod* method : exact_methods) {
                check_equal(expected, *method);
            }
        });
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
        const Case expected(shapes::floats(soup), uniform(0.5, coarse_unit_mm / 8));
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
        const Case expected(shapes::floats(soup), uniform(0.5, coarse_unit_mm / 8));
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
        each_plan(agreement::from_recipe(shape, 12'000), 20, [](const Case& expected) {
            const WholeOutcome outcome = ldni.run(expected.problem);
            REQUIRE(outcome.contours.size() == expected.result.layers.size());
            for (std::size_t i = 0; i < outcome.contours.size(); ++i) {
                double difference = 0;
                double border = 0;
                for (const Polyline& contour : agreement::as_sliced(expected.result, expected.result.layers[i])) {
                    difference -= static_cast<double>(rings::twice_area(contour.points)) / 2;
                    border += static_cast<double>(rings::perimeter(contour.points));
                }
                for (const Polyline& contour : outcome.contours[i]) {
                    CHECK(contour.closed);
                    difference += static_cast<double>(rings::twice_area(contour.points)) / 2;
                }
                INFO("layer " << i);
                CHECK(std::abs(difference) <= border * ldni_resolution_mm / expected.result.info.grid_mm);
            }
        });
    }
}
