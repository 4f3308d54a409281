// Prepared meshes: whatever they are made of and sliced with, the answer is that of the mesh, byte by byte.
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/same_result.hpp"
#include "engine/slicing.hpp"
#include "models/models.hpp"
#include "slicing/buckets/prepared_source.hpp"

using lamella::ErrorCode;
using lamella::MeshView;
using lamella::PreparedMesh;
using lamella::PrepareOptions;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

PreparedMesh prepared(const MeshView& mesh, const SliceOptions& options) {
    PrepareOptions prepare_options;
    prepare_options.unit_mm = options.unit_mm;
    prepare_options.transform = options.transform;
    prepare_options.control = options.control;
    return value_of(prepare(mesh, prepare_options));
}

/// Slices the mesh and what was prepared of it; both succeed with the same result, or fail with the same error.
void check_same(const MeshView& mesh, const PreparedMesh& made, const SliceOptions& options) {
    const lamella::Result<SliceResult> expected = slice(mesh, options);
    const lamella::Result<SliceResult> found = slice(made, options);
    REQUIRE(found.ok() == expected.ok());
    if (expected.ok()) {
        require_same(*found, *expected);
    } else {
        REQUIRE(found.error().message == expected.error().message);
    }
}

SliceOptions random_options(std::mt19937_64& random) {
    const auto one_in = [&](unsigned n) { return random() % n == 0; };
    const auto number = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() % 1000) / 1000;
    };
    SliceOptions options;
    switch (random() % 4) {
        case 0:
            options.plan.spacing = lamella::UniformLayers{.layer_height_mm = number(0.3, 3)};
            break;
        case 1:
            options.plan.spacing = lamella::RandomLayers{0.2, 0.9, random()};
            break;
        case 2:
            options.plan.spacing = lamella::ExplicitPlanes{{number(-1, 6)}};
            break;
        default:
            options.plan.spacing = lamella::ExplicitPlanes{{-50, 0.75, 1.25, 2.5, 2.625, 60}};
            break;
    }
    options.plan.side = one_in(2) ? lamella::PlaneSide::above : lamella::PlaneSide::below;
    options.tuning.form = one_in(3) ? lamella::ContourForm::assembled : lamella::ContourForm::swept;
    options.tuning.band_planes = static_cast<int>(random() % 4);
    options.control.threads = 1 + static_cast<int>(random() % 3);
    options.unit_mm = one_in(3) ? 0.125 : 0;
    if (one_in(3)) {
        options.transform = lamella::Transform::from_normal(number(-1, 1), number(0.1, 1), number(-1, 1));
    }
    options.close_gaps_mm = one_in(3) ? 0.5 : 0;
    if (one_in(3)) {
        options.region.fill_rule = one_in(2) ? lamella::FillRule::non_zero : lamella::FillRule::even_odd;
        options.region.close_mm = one_in(2) ? 0.25 : 0;
    }
    return options;
}

}  // namespace

TEST_CASE("a prepared mesh gives the bytes of the mesh for every option", "[engine][prepare][random]") {
    std::mt19937_64 random(7);
    for (int seed = 0; seed < 300; ++seed) {
        INFO("seed " << seed);
        const auto shape = static_cast<std::uint64_t>(seed);
        const std::uint64_t range = 2 + random() % 4;
        const shapes::Soup soup = seed % 3 == 0   ? shapes::random_soup(shape, 3 + seed % 40, range)
                                  : seed % 3 == 1 ? shapes::random_tetrahedra(shape, 2 + seed % 12, range)
                                                  : shapes::octasphere({1, 2, 3}, 3, seed % 4);
        const SliceOptions options = random_options(random);
        if (slice(view_of(soup), options).ok() || seed % 3 != 0) {
            const PreparedMesh made = prepared(view_of(soup), options);
            check_same(view_of(soup), made, options);
            // And again at other planes, with what is left out of the options taken from the prepared mesh.
            SliceOptions other = random_options(random);
            other.unit_mm = options.unit_mm;
            other.transform = options.transform;
            check_same(view_of(soup), made, other);
        }
    }
}

TEST_CASE("every view of a mesh can be prepared", "[engine][prepare]") {
    lamella::models::Recipe recipe;
    recipe.shape = GENERATE(lamella::models::Shape::bone, lamella::models::Shape::prism, lamella::models::Shape::gyroid);
    recipe.triangles = 20'000;
    recipe.height_mm = 20;
    const std::vector<float> soup = lamella::models::make_soup(recipe);
    const std::vector<double> wide(soup.begin(), soup.end());
    const shapes::Indexed indexed = shapes::indexed(wide);
    SliceOptions options = uniform(GENERATE(0.1, 5.0));
    options.control.threads = GENERATE(1, 3);
    for (const MeshView& view : {MeshView::soup(soup), MeshView::soup(wide), indexed.view()}) {
        check_same(view, prepared(view, options), options);
    }
}

TEST_CASE("a prepared mesh outlives the memory of the mesh", "[engine][prepare]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 3);
    const SliceResult expected = sliced(soup, uniform(0.5));
    const PreparedMesh made = prepared(view_of(soup), uniform(0.5));
    soup.assign(soup.size(), 1e300);
    const SliceResult found = value_of(slice(made, uniform(0.5)));
    require_same(found, expected);
}

TEST_CASE("a prepared mesh is sliced on its own grid and in its own frame", "[engine][prepare]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    SliceOptions options = at_heights({1, 3});
    options.transform = lamella::Transform::from_normal(1, 0, 0);
    const PreparedMesh made = prepared(view_of(soup), options);
    CHECK(made.unit_mm() == coarse_unit_mm);
    const SliceResult expected = sliced(soup, options);
    SliceOptions left_out = options;
    left_out.unit_mm = 0;
    left_out.transform = {};
    const SliceResult found = value_of(slice(made, left_out));
    require_same(found, expected);

    SliceOptions other = options;
    other.unit_mm = 0.25;
    CHECK(slice(made, other).error().code == ErrorCode::invalid_argument);
    other = options;
    other.transform = lamella::Transform::scale(2);
    CHECK(slice(made, other).error().code == ErrorCode::invalid_argument);
}

TEST_CASE("a mesh that cannot be sliced cannot be prepared", "[engine][prepare]") {
    const auto failure = [](const MeshView& mesh, const PrepareOptions& options) {
        return error_of(prepare(mesh, options));
    };
    CHECK(failure(MeshView{}, {}).code == ErrorCode::empty_mesh);
    shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    CHECK(failure(view_of(soup), {.unit_mm = 1e3}).code == ErrorCode::empty_mesh);
    CHECK(failure(view_of(soup), {.unit_mm = 1e-12}).code == ErrorCode::bad_coordinate);
    CHECK(failure(view_of(soup), {.control = {.threads = -1}}).code == ErrorCode::invalid_argument);
    soup[5 * 9 + 4] = std::numeric_limits<double>::quiet_NaN();
    CHECK(failure(view_of(soup), {}).triangle == 5);
    shapes::Indexed indexed = shapes::indexed(shapes::box({0, 0, 0}, {4, 6, 8}));
    indexed.indices[7] = 1000;
    CHECK(failure(indexed.view(), {}).triangle == 2);
}

TEST_CASE("a mesh of which nothing is left can be prepared where empty ones are allowed", "[engine][prepare]") {
    const shapes::Soup box = shapes::box({1, 2, 3}, {4, 6, 8});
    SliceOptions options;
    options.allow_empty = true;
    for (const double unit_mm : {0.0, 1e3}) {  // on the coarse grid the box collapses
        const MeshView mesh = unit_mm == 0 ? MeshView{} : view_of(box);
        options.unit_mm = unit_mm;
        const auto made = value_of(prepare(mesh, {.unit_mm = unit_mm, .allow_empty = true}));
        options.plan.spacing = lamella::ExplicitPlanes{.heights_mm = {4, 5, 5}};
        require_same(slice(made, options).value(), slice(mesh, options).value());
        CHECK(slice(made, options).value().layers.size() == (unit_mm == 0 ? 2 : 1));
        options.plan.spacing = lamella::UniformLayers{.layer_height_mm = 1};
        require_same(slice(made, options).value(), slice(mesh, options).value());
        SliceOptions refusing = options;
        refusing.allow_empty = false;
        CHECK(slice(made, refusing).error().message == slice(mesh, refusing).error().message);
    }
}

TEST_CASE("a prepared mesh takes 48 bytes a triangle of the host's memory", "[engine][prepare]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    const std::size_t triangles = soup.size() / 9;
    CountingMemory memory;
    const lamella::Memory hosts = memory_of(memory);
    {
        const lamella::Result<PreparedMesh> made = prepare(view_of(soup), {.control = {.memory = &hosts}});
        REQUIRE(made.ok());
        CHECK(memory.held() >= 48 * triangles);
        CHECK(memory.held() <= 49 * triangles);
        CHECK(made->bytes() >= memory.held());
        CHECK(made->bytes() <= memory.held() + 4096);
    }
    CHECK(memory.held() == 0);
}

TEST_CASE("a plane reads little more than the triangles that it cuts", "[engine][prepare][bucket]") {
    // Small triangles everywhere, and among every hundred of them one as tall as the mesh, in any order.
    std::mt19937 random(3);
    std::uniform_real_distribution<float> place(0, 100);
    std::vector<float> soup;
    for (int t = 0; t < 200'000; ++t) {
        const float x = place(random);
        const float z = t % 100 == 0 ? 0 : place(random);
        soup.insert(soup.end(), {x, 0, z, x + 1, 0, z, x, 1, z + (t % 100 == 0 ? 100.5F : 0.05F)});
    }
    const PreparedMesh made = prepared(MeshView::soup(soup), {});
    const lamella::detail::PreparedParts& parts = made.parts();
    lamella::PlaneSet planes(nullptr);
    lamella::LayerPlan plan;
    plan.spacing = lamella::ExplicitPlanes{{50.1}};
    REQUIRE(planes.build(plan, parts.frame.bounds, parts.frame.unit.mm, parts.frame.number, 1 << 20));
    lamella::Buckets buckets(nullptr);
    const lamella::Parallel parallel({.threads = 1});
    lamella::PreparedSource(parts, {parallel, planes, buckets}).count(parts.frame.unit.mm);
    CHECK(buckets.segment_count >= 2000);
    CHECK(buckets.touched.size() * 64 <= 2 * buckets.segment_count);
}
