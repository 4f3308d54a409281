// What upward and downward faces project onto layers, against drawings and against slice().
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slabs.hpp"
#include "engine/slicing.hpp"
#include "golden/shape_cases.hpp"

using lamella::PlaneSide;
using lamella::Point;
using namespace slab_tests;

namespace {

using Lines = std::vector<std::string>;

/// A box on a larger one.
shapes::Soup steps() {
    return shapes::joined({shapes::box({0, 0, 0}, {8, 8, 2}), shapes::box({2, 2, 2}, {6, 6, 5})});
}

lamella::Error slab_failure(const MeshView& mesh, const SlabOptions& options) {
    return error_of(slice_slabs(mesh, options));
}

lamella::SliceOptions as_slice(const SlabOptions& options) {
    lamella::SliceOptions same;
    same.plan = options.plan;
    same.unit_mm = options.unit_mm;
    same.unit_fit = options.unit_fit;
    same.allow_empty = options.allow_empty;
    same.transform = options.transform;
    same.memory_limit_bytes = options.memory_limit_bytes;
    same.control = options.control;
    return same;
}

}  // namespace

TEST_CASE("a box projects its top and its bottom, and nothing between", "[engine][slabs]") {
    const Slabs slabs = slabs_of(shapes::box({0, 0, 0}, {4, 3, 10}), slabs_at({-2, 1, 5, 9, 12}));
    const Lines rectangle = {"outer + x4 in -: 0,0 8,0 8,6 0,6"};
    CHECK(contours_at(slabs.top, 3) == rectangle);
    CHECK(contours_at(slabs.bottom, 1) == rectangle);
    for (const std::size_t layer : {0U, 1U, 2U, 4U}) {
        CHECK(contours_at(slabs.top, layer).empty());
    }
    for (const std::size_t layer : {0U, 2U, 3U, 4U}) {
        CHECK(contours_at(slabs.bottom, layer).empty());
    }
    CHECK(slabs.top.layers[3].segments == 2);
    CHECK(slabs.top.summary.crossed == 2);
    CHECK(slabs.top.summary.segments == 2);
    CHECK(slabs.top.summary.triangles == 12);
}

TEST_CASE("a horizontal face on a plane lies above it or below it as the plan says", "[engine][slabs]") {
    SlabOptions options = slabs_at({0, 5, 10});
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 10});
    const Lines square = {"outer + x4 in -: 0,0 8,0 8,8 0,8"};
    SECTION("below: an upward face projects to its own plane, a downward one to the next above") {
        const Slabs slabs = slabs_of(box, options);
        CHECK(contours_at(slabs.top, 2) == square);
        CHECK(contours_at(slabs.bottom, 1) == square);
        CHECK(twice_area(slabs.top) == 128);
        CHECK(twice_area(slabs.bottom) == 128);
    }
    SECTION("above: an upward face projects to the next plane below, a downward one to its own") {
        options.plan.side = PlaneSide::above;
        const Slabs slabs = slabs_of(box, options);
        CHECK(contours_at(slabs.top, 1) == square);
        CHECK(contours_at(slabs.bottom, 0) == square);
        CHECK(twice_area(slabs.top) == 128);
        CHECK(twice_area(slabs.bottom) == 128);
    }
}

TEST_CASE("upward faces below the lowest plane and downward ones above the highest project to none", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 10});
    const Slabs above = slabs_of(box, slabs_at({11, 12}));
    CHECK(above.top.contours.empty());
    CHECK(above.top.summary.crossed == 0);
    CHECK(twice_area(above.bottom, above.bottom.layers[0]) == 128);
    const Slabs below = slabs_of(box, slabs_at({-5, -1}));
    CHECK(below.bottom.contours.empty());
    CHECK(below.bottom.summary.crossed == 0);
    CHECK(twice_area(below.top, below.top.layers[1]) == 128);
}

TEST_CASE("each step projects its own faces, and a slope between two planes a frame", "[engine][slabs]") {
    const Slabs slabs = slabs_of(steps(), slabs_at({1, 3}));
    // The cap of the lower box is whole: where the upper one stands, its bottom lies on it.
    CHECK(contours_at(slabs.top, 0) == Lines{"outer + x4 in -: 0,0 16,0 16,16 0,16"});
    CHECK(contours_at(slabs.top, 1) == Lines{"outer + x4 in -: 4,4 12,4 12,12 4,12"});
    CHECK(contours_at(slabs.bottom, 0) == Lines{"outer + x4 in -: 0,0 16,0 16,16 0,16"});
    CHECK(contours_at(slabs.bottom, 1) == Lines{"outer + x4 in -: 4,4 12,4 12,12 4,12"});
    // A pyramid cut at two heights: the slab between them is a frame.
    const shapes::Soup pyramid = shapes::joined(
        {shapes::triangle({0, 0, 0}, {8, 0, 0}, {4, 4, 4}), shapes::triangle({8, 0, 0}, {8, 8, 0}, {4, 4, 4}),
         shapes::triangle({8, 8, 0}, {0, 8, 0}, {4, 4, 4}), shapes::triangle({0, 8, 0}, {0, 0, 0}, {4, 4, 4})});
    SlabOptions side = slabs_at({1, 3});
    const Slabs frame = slabs_of(pyramid, side);
    CHECK(contours_at(frame.top, 0) == Lines{"outer + x4 in -: 1,1 15,1 15,15 1,15", "hole - x4 in 0: 5,5 5,11 11,11 11,5"});
    CHECK(contours_at(frame.top, 1) == Lines{"outer + x4 in -: 5,5 11,5 11,11 5,11"});
    const auto islands = islands_of(frame.top.contours_of(frame.top.layers[0]));
    CHECK((*islands.begin()).holes.size() == 1);
    CHECK(frame.bottom.contours.empty());
}

TEST_CASE("a face between two planes is one piece, and one across planes is cut", "[engine][slabs]") {
    const shapes::Soup low = shapes::triangle({0, 0, 2}, {4, 0, 3}, {0, 4, 3});
    const Slabs whole = slabs_of(low, slabs_at({1, 5}));
    CHECK(contours_at(whole.top, 0) == Lines{"outer + x3 in -: 0,0 8,0 0,8"});
    CHECK(whole.top.summary.segments == 1);
    const shapes::Soup tall = shapes::triangle({0, 0, 0}, {8, 0, 0}, {0, 0.5, 8});
    const Slabs cut = slabs_of(tall, slabs_at({-1, 2, 4, 6}, 0));
    CHECK(cut.top.summary.segments == 4);
    CHECK(cut.top.summary.crossed == 1);
    for (std::size_t layer = 0; layer < 4; ++layer) {
        CHECK(cut.top.layers[layer].segments == 1);
    }
}

TEST_CASE("heights may be listed in any order and coincide", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    const Slabs sorted = slabs_of(ball, slabs_at({-3, 0, 2}, 0));
    const Slabs listed = slabs_of(ball, slabs_at({2, -3, 0, 2, -3}, 0));
    CHECK(hash_of(listed) == hash_of(sorted));
    CHECK(std::vector<std::uint64_t>(listed.top.layer_of.begin(), listed.top.layer_of.end()) ==
          std::vector<std::uint64_t>{2, 0, 1, 2, 0});
    CHECK(std::equal(listed.bottom.layer_of.begin(), listed.bottom.layer_of.end(), listed.top.layer_of.begin()));
}

TEST_CASE("the bands of a ball share their borders with slices, and their areas add up exactly", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({1, 2, 0}, 5, 4);
    SlabOptions options = slabs_at({-20, 0.3, 1.1, 2.5, 2.75, 4, 4.9}, 0);
    const Slabs slabs = slabs_of(ball, options);
    const SliceResult slice = sliced(ball, as_slice(options));
    CHECK(twice_area(slabs.top) == twice_upward_area(ball, slabs.top.unit_mm));
    const auto points = [](const SliceResult& result, std::uint64_t contour) {
        const auto own = result.points_of(result.contours[contour]);
        std::vector<std::pair<int, int>> sorted;
        for (const Point p : own) {
            sorted.emplace_back(p.x, p.y);
        }
        std::sort(sorted.begin(), sorted.end());
        return sorted;
    };
    for (std::size_t layer = 1; layer < slice.layers.size(); ++layer) {
        const bool last = layer + 1 == slice.layers.size();
        REQUIRE(slabs.top.layers[layer].contour_count == (last ? 1 : 2));
        const std::uint64_t outer = slabs.top.layers[layer].first_contour;
        CHECK(points(slabs.top, outer) == points(slice, slice.layers[layer].first_contour));
        if (!last) {
            CHECK(points(slabs.top, outer + 1) == points(slice, slice.layers[layer + 1].first_contour));
        }
    }
}

TEST_CASE("two planes far below and far above give the whole shadow", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    const Slabs slabs = slabs_of(ball, slabs_at({-1e9, 1e9}, 0));
    CHECK(twice_area(slabs.top, slabs.top.layers[0]) == twice_upward_area(ball, slabs.top.unit_mm));
    CHECK(slabs.top.layers[1].contour_count == 0);
    CHECK(slabs.bottom.layers[0].contour_count == 0);
    CHECK(twice_area(slabs.bottom) == twice_area(slabs.top));
}

TEST_CASE("a transform that mirrors turns no face inside out", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 3, 10});
    SlabOptions options = slabs_at({1, 9});
    options.transform.m[5] = -1;
    const Slabs slabs = slabs_of(box, options);
    CHECK(contours_at(slabs.top, 1) == Lines{"outer + x4 in -: 0,-6 8,-6 8,0 0,0"});
    CHECK(contours_at(slabs.bottom, 0) == Lines{"outer + x4 in -: 0,-6 8,-6 8,0 0,0"});
    CHECK(slabs.top.layers[0].contour_count == 0);
}

TEST_CASE("slabs do not depend on threads or on the order of triangles", "[engine][slabs][determinism][threads]") {
    for (const auto& [name, mesh] : shape_cases::meshes()) {
        for (const double layer : {0.3, 40.0}) {
            SlabOptions options;
            options.plan.spacing = lamella::UniformLayers{.layer_height_mm = layer, .first_height_mm = 0.01};
            options.control.threads = 1;
            const std::uint64_t expected = hash_of(slabs_of(mesh, options));
            INFO(name);
            for (const int threads : {2, 5}) {
                options.control.threads = threads;
                CHECK(hash_of(slabs_of(mesh, options)) == expected);
            }
            for (const std::uint64_t seed : {1U, 2U, 3U}) {
                CHECK(hash_of(slabs_of(shapes::shuffled(mesh, seed), options)) == expected);
            }
        }
    }
}

TEST_CASE("any view of a mesh gives the same slabs", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    const std::uint64_t expected = hash_of(slabs_of(ball, slabs_at({-2, 1, 2}, 0)));
    CHECK(hash_of(slabs_of(shapes::indexed(ball).view(), slabs_at({-2, 1, 2}, 0))) == expected);
}

TEST_CASE("one of very many layers is what its two planes alone give", "[engine][slabs][threads]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 3);
    constexpr std::size_t planes = 9'001;
    std::vector<double> heights;
    for (std::size_t i = 0; i < planes; ++i) {
        heights.push_back(-6 + 12 * static_cast<double>(i) / (planes - 1));
    }
    SlabOptions options = slabs_at(heights, 0);
    options.control.threads = 3;
    const Slabs all = slabs_of(ball, options);
    REQUIRE(all.top.layers.size() == planes);
    CHECK(twice_area(all.top) == twice_upward_area(ball, all.top.unit_mm));
    for (const std::size_t layer : {4'500U, 4'501U, 5'000U, 6'999U, 8'249U}) {
        const Slabs two = slabs_of(ball, slabs_at({heights[layer], heights[layer + 1]}, 0));
        CHECK(twice_area(all.top, all.top.layers[layer]) == twice_area(two.top, two.top.layers[0]));
        CHECK(all.top.layers[layer].segments == two.top.layers[0].segments);
        const Slabs below = slabs_of(ball, slabs_at({heights[planes - layer], heights[planes - 1 - layer]}, 0));
        const lamella::Layer& low = all.bottom.layers[planes - layer];
        CHECK(twice_area(all.bottom, low) == twice_area(below.bottom, below.bottom.layers[1]));
        CHECK(low.segments == below.bottom.layers[1].segments);
        CHECK(low.segments > 0);
    }
}

TEST_CASE("pieces on top of one another are united, whatever their number", "[engine][slabs]") {
    const shapes::Soup sheet = shapes::triangle({0, 0, 1}, {4, 0, 1}, {0, 4, 1});
    const shapes::Soup stack = shapes::joined(
        {sheet, shapes::moved(sheet, {0, 0, 0.5}), shapes::moved(sheet, {0, 0, 0.5}), shapes::moved(sheet, {1, 1, 1})});
    const Slabs slabs = slabs_of(stack, slabs_at({0, 9}));
    CHECK(contours_at(slabs.top, 0) == Lines{"outer + x7 in -: 0,0 8,0 6,2 10,2 2,10 2,6 0,8"});
    CHECK(slabs.top.layers[0].segments == 4);
    CHECK(slabs.top.layers.size() == 2);
}

TEST_CASE("rules of regions follow the union", "[engine][slabs][regions]") {
    const shapes::Soup parts = shapes::joined({shapes::box({0, 0, 0}, {4, 4, 4}), shapes::box({5, 0, 0}, {8, 4, 4})});
    SlabOptions options = slabs_at({2});
    options.bottom = false;
    SECTION("points within straight lines go") {
        const shapes::Soup tilted = shapes::joined(
            {shapes::triangle({0, 0, 3}, {4, 0, 3}, {4, 4, 3}), shapes::triangle({0, 0, 3}, {4, 4, 3}, {0, 4, 3}),
             shapes::triangle({4, 0, 3}, {8, 0, 3}, {8, 4, 3}), shapes::triangle({4, 0, 3}, {8, 4, 3}, {4, 4, 3})});
        CHECK(contours_at(slabs_of(tilted, options).top, 0) == Lines{"outer + x6 in -: 0,0 8,0 16,0 16,8 8,8 0,8"});
        options.region.drop_collinear = true;
        const Lines plain = contours_at(slabs_of(tilted, options).top, 0);
        CHECK(plain == Lines{"outer + x6 in -: 0,0 16,0 16,8 0,8"});
    }
    SECTION("gaps are closed") {
        options.region.close_mm = 1;
        CHECK(slabs_of(parts, options).top.layers[0].contour_count == 1);
    }
    SECTION("the largest stays") {
        options.region.largest_only = true;
        CHECK(contours_at(slabs_of(parts, options).top, 0) == Lines{"outer + x4 in -: 0,0 8,0 8,8 0,8"});
    }
    SECTION("layers that the rules empty are counted") {
        options.region.offset_mm = -2.5;
        const Slabs slabs = slabs_of(parts, options);
        CHECK(slabs.top.contours.empty());
        CHECK(slabs.top.summary.emptied_layers == 1);
    }
}

TEST_CASE("what is not asked for has no layers", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 2);
    SlabOptions options = slabs_at({-2, 1, 2}, 0);
    const Slabs both = slabs_of(ball, options);
    options.bottom = false;
    const Slabs top = slabs_of(ball, options);
    CHECK(hash_result(top.top) == hash_result(both.top));
    CHECK(top.bottom.layers.empty());
    options.bottom = true;
    options.top = false;
    const Slabs bottom = slabs_of(ball, options);
    CHECK(hash_result(bottom.bottom) == hash_result(both.bottom));
    CHECK(bottom.top.layers.empty());
}

TEST_CASE("slabs refuse what slice() refuses, in the same words", "[engine][slabs][errors]") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    const auto same = [&](const MeshView& mesh, const SlabOptions& options, lamella::ErrorCode code) {
        const lamella::Error expected = failure_of(mesh, as_slice(options));
        const lamella::Error found = slab_failure(mesh, options);
        CHECK(found.message == expected.message);
        CHECK(found.code == expected.code);
        CHECK(found.code == code);
        CHECK(found.triangle == expected.triangle);
        CHECK(found.plane == expected.plane);
    };
    using lamella::ErrorCode;
    shapes::Soup bad = box;
    bad[40] = nan;
    same(view_of(bad), slabs_at({1}), ErrorCode::bad_coordinate);
    bad[40] = 2e9;
    same(view_of(bad), slabs_at({1}), ErrorCode::bad_coordinate);
    same(view_of({}), slabs_at({1}), ErrorCode::empty_mesh);
    const shapes::Soup point = shapes::triangle({0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0});
    same(view_of(point), slabs_at({1}), ErrorCode::empty_mesh);
    same(view_of(box), slabs_at({1, nan}), ErrorCode::bad_planes);
    same(view_of(box), slabs_at({1}, 1e-18), ErrorCode::invalid_argument);
    same(view_of(box), slabs_at({1}, 1e-9), ErrorCode::bad_coordinate);
    shapes::Indexed indexed = shapes::indexed(box);
    indexed.indices[7] = 99;
    same(indexed.view(), slabs_at({1}), ErrorCode::invalid_argument);
    SlabOptions negative = slabs_at({1});
    negative.control.threads = -1;
    same(view_of(box), negative, ErrorCode::invalid_argument);
}

TEST_CASE("slabs refuse what has no meaning for them", "[engine][slabs][errors]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SlabOptions options = slabs_at({1});
    SECTION("neither") {
        options.top = options.bottom = false;
        CHECK(slab_failure(view_of(box), options).message == "neither top nor bottom is asked for");
    }
    SECTION("a fill rule") {
        options.region.fill_rule = lamella::FillRule::non_zero;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::Contains("fill rule"));
    }
    SECTION("lengths that are none") {
        options.region.close_mm = -1;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::StartsWith("the closing radius"));
        options.region.close_mm = 1e9;
        CHECK_THAT(slab_failure(view_of(box), options).message, Catch::Contains("beyond the grid"));
    }
    SECTION("more than the memory limit") {
        options.memory_limit_bytes = 150;
        const lamella::Error error = slab_failure(view_of(box), options);
        CHECK(error.code == lamella::ErrorCode::result_too_large);
        CHECK(error.message == "1 layer with 4 pieces of faces need 160 bytes, more than the memory limit of 150");
    }
}

TEST_CASE("an empty mesh gives empty layers where asked", "[engine][slabs]") {
    SlabOptions options = slabs_at({3, 1, 2}, 0);
    options.allow_empty = true;
    for (const shapes::Soup& soup : {shapes::Soup{}, shapes::triangle({0, 0, 0}, {0, 0, 0}, {0, 1e-9, 0})}) {
        const Slabs slabs = slabs_of(soup, options);
        CHECK(slabs.top.layers.size() == 3);
        CHECK(slabs.bottom.layers.size() == 3);
        CHECK(slabs.top.contours.empty());
        CHECK(slabs.top.layer_of[0] == 2);
        options.plan.spacing = lamella::UniformLayers{};
        CHECK(slabs_of(soup, options).top.layers.empty());
        options.plan.spacing = lamella::ExplicitPlanes{{3, 1, 2}};
    }
}

TEST_CASE("a coarser unit is taken where the mesh needs one", "[engine][slabs]") {
    const shapes::Soup box = shapes::box({0, 0, 0}, {4, 4, 4});
    SlabOptions options = slabs_at({1}, 0x1p-29);
    options.unit_fit = lamella::UnitFit::coarser_if_needed;
    const Slabs slabs = slabs_of(box, options);
    CHECK(slabs.top.summary.unit_doublings == 2);
    CHECK(slabs.bottom.unit_mm == 0x1p-27);
    CHECK(slabs.top.area_mm2(slabs.top.layers[0]) == 16);
}

TEST_CASE("slabs take their memory from the host and hold no more than their result", "[engine][slabs]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 5, 5);
    CountingMemory memory;
    {
        SlabOptions options = slabs_at({-2, 0, 1, 2}, 0);
        options.control.memory = &memory;
        const Slabs slabs = slabs_of(ball, options);
        std::size_t bytes = 0;
        for (const SliceResult* const result : {&slabs.top, &slabs.bottom}) {
            bytes += result->layers.capacity() * sizeof(lamella::Layer) +
                     result->contours.capacity() * sizeof(lamella::Contour) + result->points.capacity() * sizeof(Point) +
                     result->layer_of.capacity() * sizeof(std::uint64_t);
        }
        CHECK(memory.held() == bytes);
        CHECK(memory.peak() > slabs.top.summary.segments * 8);
    }
    CHECK(memory.held() == 0);
}
