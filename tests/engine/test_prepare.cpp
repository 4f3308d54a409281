// Prepared meshes: whatever they are made of and sliced with, the answer is that of the mesh, byte by byte.
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/same_result.hpp"
#include "engine/slicing.hpp"
#include "slicing/buckets/prepared_source.hpp"

using lamella::ErrorCode;
using lamella::Frame;
using lamella::MeshView;
using lamella::PreparedMesh;
using lamella::SliceOptions;
using lamella::SliceResult;

namespace {

struct Asked {
    SliceOptions options;
    Way way;
};

lamella::Result<SliceResult> slice_as(const lamella::Source& source, const Asked& asked) {
    lamella::Slicer slicer;
    SliceResult result;
    const auto info = slice_tuned(slicer, result, source, asked.options, asked.way.tuning, asked.way.context);
    if (!info) {
        return info.error();
    }
    return result;
}

/// Slices the mesh and what was prepared of it; both succeed with the same result, or fail with the same error.
void check_same(const MeshView& mesh, const PreparedMesh& made, const Asked& asked) {
    const lamella::Result<SliceResult> expected = slice_as(mesh, asked);
    const lamella::Result<SliceResult> found = slice_as(made, asked);
    REQUIRE(found.ok() == expected.ok());
    if (expected.ok()) {
        require_same(*found, *expected);
    } else {
        REQUIRE(found.error().message == expected.error().message);
    }
}

Asked random_options(std::mt19937_64& random) {
    const auto one_in = [&](unsigned n) { return random() % n == 0; };
    const auto number = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() % 1000) / 1000;
    };
    Asked asked;
    SliceOptions& options = asked.options;
    switch (random() % 4) {
        case 0:
            options.layer_height_mm = number(0.3, 3);
            break;
        case 1:
            asked.way.tuning.random_heights = lamella::RandomHeights{0.2, 0.9, random()};
            break;
        case 2:
            options.heights_mm = {{number(-1, 6)}};
            break;
        default:
            options.heights_mm = {{-50, 0.75, 1.25, 2.5, 2.625, 60}};
            break;
    }
    options.planes.side = one_in(2) ? lamella::PlaneSide::above : lamella::PlaneSide::below;
    asked.way.tuning.form = one_in(3) ? lamella::ContourForm::assembled : lamella::ContourForm::swept;
    asked.way.tuning.band_planes = static_cast<int>(random() % 4);
    asked.way.context.threads = 1 + static_cast<int>(random() % 3);
    options.frame.grid_mm = one_in(3) ? 0.125 : 0;
    if (one_in(3)) {
        options.frame.transform = lamella::Transform::from_normal(number(-1, 1), number(0.1, 1), number(-1, 1));
    }
    options.stitch_mm = one_in(3) ? 0.5 : 0;
    if (one_in(3)) {
        options.region.fill_rule = one_in(2) ? lamella::FillRule::non_zero : lamella::FillRule::even_odd;
        options.region.closing_mm = one_in(2) ? 0.25 : 0;
    }
    return asked;
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
        const Asked asked = random_options(random);
        const PreparedMesh made = value_of(prepare(view_of(soup), asked.options.frame, asked.way.context));
        check_same(view_of(soup), made, asked);
        // And again at other planes.
        Asked other = random_options(random);
        other.options.frame = asked.options.frame;
        check_same(view_of(soup), made, other);
    }
}

TEST_CASE("every view of a mesh can be prepared", "[engine][prepare]") {
    using lamella::models::Shape;
    const shapes::Soup wide = generated(GENERATE(Shape::bone, Shape::prism, Shape::gyroid), 20'000);
    const std::vector<float> soup = shapes::floats(wide);
    const shapes::Indexed indexed = shapes::indexed(wide);
    const Asked asked{uniform(GENERATE(0.1, 5.0)), {.context = {.threads = GENERATE(1, 3)}}};
    for (const MeshView& view : {view_of(soup), view_of(wide), indexed.view()}) {
        check_same(view, value_of(prepare(view, {}, asked.way.context)), asked);
    }
}

TEST_CASE("a prepared mesh outlives the memory of the mesh", "[engine][prepare]") {
    shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 3);
    const SliceResult expected = sliced(soup, uniform(0.5));
    const PreparedMesh made = value_of(prepare(view_of(soup)));
    soup.assign(soup.size(), 1e300);
    require_same(sliced(made, uniform(0.5)), expected);
}

TEST_CASE("a prepared mesh is sliced on its own grid and in its own frame", "[engine][prepare]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    SliceOptions options = at_heights({1, 3});
    options.frame.transform = lamella::Transform::from_normal(1, 0, 0);
    const PreparedMesh made = value_of(prepare(view_of(soup), options.frame));
    CHECK(made.frame() == options.frame);
    SliceOptions left_out = options;
    left_out.frame = {};
    require_same(sliced(made, left_out), sliced(soup, options));

    SliceOptions other = options;
    other.frame.grid_mm = 0.25;
    CHECK(failure_of(made, other).code == ErrorCode::invalid_argument);
    other = options;
    other.frame.transform = lamella::Transform::scale(2);
    CHECK(failure_of(made, other).code == ErrorCode::invalid_argument);
}

TEST_CASE("a mesh that no grid holds cannot be prepared; of one that is empty slicing says so", "[engine][prepare]") {
    const auto failure = [](const MeshView& mesh, const Frame& frame = {}, const lamella::Context& context = {}) {
        return error_of(prepare(mesh, frame, context));
    };
    shapes::Soup soup = shapes::box({0, 0, 0}, {4, 6, 8});
    for (const Frame& frame : {Frame{}, Frame{.grid_mm = 1e3}}) {  // on the coarse grid the box collapses
        const MeshView mesh = frame.grid_mm == 0 ? MeshView{} : view_of(soup);
        check_same(mesh, value_of(prepare(mesh, frame)), {{.frame = frame}, {}});
    }
    CHECK(failure(view_of(soup), {.grid_mm = 1e-12}).code == ErrorCode::bad_coordinate);
    CHECK(failure(view_of(soup), {}, {.threads = -1}).code == ErrorCode::invalid_argument);
    soup[5 * 9 + 4] = std::numeric_limits<double>::quiet_NaN();
    CHECK(failure(view_of(soup)).triangle == 5);
    shapes::Indexed indexed = shapes::indexed(shapes::box({0, 0, 0}, {4, 6, 8}));
    indexed.indices[7] = 1000;
    CHECK(failure(indexed.view()).triangle == 2);
}

TEST_CASE("a prepared mesh takes 48 bytes a triangle of the host's memory", "[engine][prepare]") {
    const shapes::Soup soup = shapes::octasphere({0, 0, 0}, 10, 6);
    const std::size_t triangles = soup.size() / 9;
    CountingMemory memory;
    {
        const PreparedMesh made = value_of(prepare(view_of(soup), {}, {.memory = &memory}));
        CHECK(memory.held() >= 48 * triangles);
        CHECK(memory.held() <= 49 * triangles);
        CHECK(made.bytes() >= memory.held());
        CHECK(made.bytes() <= memory.held() + 4096);
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
    const PreparedMesh made = value_of(prepare(view_of(soup)));
    const lamella::detail::PreparedImpl& prepared = *lamella::Source(made).prepared();
    lamella::PlaneSet planes(nullptr);
    planes.build({.heights_mm = {{50.1}}}, {}, prepared.frame, 1 << 20);
    lamella::Buckets buckets(nullptr);
    const lamella::Parallel parallel({.threads = 1});
    lamella::PreparedSource(prepared, {parallel, planes, buckets}).count(prepared.frame.unit.mm);
    CHECK(buckets.segment_count >= 2000);
    CHECK(buckets.touched.size() * 64 <= 2 * buckets.segment_count);
}
