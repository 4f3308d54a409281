// The same mesh gives the same bytes, whatever the threads, bands and forms, and whatever the order of triangles.
#include <cmath>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::ContourForm;
using shape_cases::meshes;
using shape_cases::plans;

namespace {

#ifdef LAMELLA_TESTS_SANITIZED
constexpr int thread_counts[] = {1, 3};
constexpr int band_sizes[] = {0, 2};
#else
constexpr int thread_counts[] = {1, 2, 3, 8};
constexpr int band_sizes[] = {0, 1, 2, 7, 1000};
#endif

}  // namespace

TEST_CASE("threads, bands and forms do not change the output", "[engine][determinism][threads]") {
    for (const auto& [mesh_name, mesh] : meshes()) {
        lamella::SliceOptions options = uniform(0.125);
        options.control.threads = 1;
        const std::uint64_t expected = hash_result(sliced(mesh, options));
        for (const int threads : thread_counts) {
            for (const int band : band_sizes) {
                for (const ContourForm form : {ContourForm::swept, ContourForm::assembled}) {
                    options.control.threads = threads;
                    options.tuning.band_planes = band;
                    options.tuning.form = form;
                    const lamella::Result<lamella::SliceResult> result = slice(view_of(mesh), options);
                    INFO(mesh_name << ", threads " << threads << ", band " << band << ", assembled "
                                   << (form == ContourForm::assembled));
                    REQUIRE(result.ok());
                    REQUIRE(hash_result(*result) == expected);
                }
            }
        }
    }
}

TEST_CASE("the order of triangles and of their vertices does not change the output", "[engine][determinism]") {
    for (const auto& [mesh_name, mesh] : meshes()) {
        for (const auto& [plan_name, options] : plans()) {
            const std::uint64_t expected = hash_result(sliced(mesh, options));
            for (const std::uint64_t seed : {1U, 2U, 3U}) {
                INFO(mesh_name << ", " << plan_name << ", shuffle " << seed);
                CHECK(hash_result(sliced(shapes::shuffled(mesh, seed), options)) == expected);
            }
        }
    }
}

TEST_CASE("repeated triangles may come in any order", "[engine][determinism]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 1);
    const shapes::Soup tangle = shapes::random_tetrahedra(3, 6, 4);
    for (const shapes::Soup& mesh : {shapes::joined({ball, ball}), shapes::joined({ball, ball, ball}),
                                     shapes::joined({ball, shapes::flipped(ball), ball}),
                                     shapes::joined({tangle, tangle, shapes::flipped(tangle), tangle})}) {
        const lamella::SliceResult result = sliced(mesh, uniform(0.25));
        CHECK(result.summary.open_contours == 0);
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            INFO("shuffle " << seed);
            REQUIRE(hash_result(sliced(shapes::shuffled(mesh, seed), uniform(0.25))) == hash_result(result));
        }
    }
}

TEST_CASE("equal parts give equal contours anywhere on the grid", "[engine][determinism]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 3);
    const lamella::SliceResult here = sliced(ball, uniform(0.25, 0x1p-10));
    // Coordinates are rounded to the grid first, so that moving rounds nothing.
    shapes::Soup on_grid = ball;
    for (double& number : on_grid) {
        number = std::nearbyint(number * 0x1p9) * 0x1p-9;
    }
    const lamella::SliceResult there = sliced(shapes::moved(on_grid, {64, -32, 16}), uniform(0.25, 0x1p-10));
    REQUIRE(there.points.size() == here.points.size());
    std::size_t equal = 0;
    for (std::size_t i = 0; i < here.points.size(); ++i) {
        equal += there.points[i].x - here.points[i].x == 64 * 1024 && there.points[i].y - here.points[i].y == -32 * 1024;
    }
    CHECK(equal == here.points.size());
}
