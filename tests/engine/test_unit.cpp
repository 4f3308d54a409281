// The grid's unit, meshes that do not fit the unit asked for, are too small or too far away for their numbers, or are empty,
// and results that would be too large.
#include <cmath>

#include "base/system/machine.hpp"
#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"

using namespace lamella;
using shapes::box;

namespace {

/// The scale of a box from (low, low, low) to (low + edge, ...), on the default grid unless told otherwise.
MeshScale scale_of(double low, double edge, Number number, double grid_mm = default_grid_mm) {
    return judge_scale({{low, low, low}, {low + edge, low + edge, low + edge}}, number, grid_mm);
}

TEST_CASE("the unit by box is the finest power of two that the mesh fits", "[engine][unit]") {
    for (const double edge : {1e-6, 0.013, 1.0, 3.0, 700.0, 2.5e4, 8e8}) {
        const SliceResult result = sliced(shapes::box({0, 0, 0}, {edge, edge, edge}), uniform(edge / 3, finest_grid));
        INFO("edge " << edge << " mm, unit " << result.info.grid_mm);
        CHECK(std::log2(result.info.grid_mm) == std::round(std::log2(result.info.grid_mm)));
        CHECK(edge <= result.info.grid_mm * (grid_limit - 2));
        CHECK(edge > result.info.grid_mm / 2 * (grid_limit - 2));
        REQUIRE(result.layers.size() == 3);
        CHECK(result[1].area_mm2() == Approx(edge * edge).epsilon(1e-8));
    }
}

TEST_CASE("the unit by box leaves room for what rules move", "[engine][unit]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {0.9995, 0.9995, 0.9995});
    SliceOptions options = at_heights({0.5}, finest_grid);
    CHECK(sliced(cube, options).info.grid_mm == 0x1p-30);
    options.region.fill_rule = FillRule::non_zero;
    CHECK(sliced(cube, options).info.grid_mm == 0x1p-30);
    const auto [offset, close, mark] =
        GENERATE(table<double, double, double>({{0.002, 0, 0}, {0, 0.002, 0}, {0, 0, 0.002}}));
    options.region.offset_mm = offset;
    options.region.closing_mm = close;
    options.region.flag_closing_mm = mark;
    const SliceResult grown = sliced(cube, options);
    CHECK(grown.info.grid_mm == 0x1p-29);
    CHECK(grown[0].area_mm2() == Approx(std::pow(0.9995 + 2 * offset, 2)));
    // A unit that may be doubled is; one that is asked for is refused.
    options.frame.grid_mm = 0x1p-30;
    CHECK(failure_of(view_of(cube), options).message.find("choose a unit of more than") != std::string::npos);
    options.frame.coarser_if_needed = true;
    CHECK(sliced(cube, options).info.grid_doublings == 1);
}

TEST_CASE("a transform that flattens every mesh is refused, whatever the call", "[engine][unit]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {1, 1, 1});
    SliceOptions options = uniform(0.1);
    auto& m = options.frame.transform.m;
    m = GENERATE(std::array<double, 12>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0},
                 std::array<double, 12>{1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 1});
    CHECK(options.frame.transform.is_singular());
    const Error error = failure_of(view_of(cube), options);
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message.find("singular") != std::string::npos);
    CHECK(error_of(check(view_of(cube), {.frame = options.frame, .counts_only = true})).message == error.message);
    CHECK(error_of(prepare(view_of(cube), options.frame)).message == error.message);
    for (const double small : {1e-9, -1e-3, 1e6}) {
        CHECK_FALSE(Transform::scale(small).is_singular());
    }
    m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-9, 0};
    CHECK_FALSE(options.frame.transform.is_singular());
}

TEST_CASE("types that numbers of a mesh cannot have are refused, whatever the call", "[engine][unit][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {1, 1, 1});
    MeshView mesh = view_of(soup);
    mesh.vertex_type = GENERATE(Number::u32, Number::u64);
    for (const auto& code : {code_of(slice(mesh)), code_of(check(mesh)), code_of(weld(mesh)), code_of(prepare(mesh))}) {
        CHECK(code == ErrorCode::invalid_argument);
    }
}

TEST_CASE("a mesh of which every triangle collapses is empty", "[engine][unit]") {
    const shapes::Soup speck = shapes::box({5, 5, 5}, {5 + 1e-9, 5 + 1e-9, 5 + 1e-9});
    const std::string reason = "each of 12 triangles has two equal corners on the grid of 9.5367431640625e-07 mm";
    for (const Error& error :
         {failure_of(view_of(speck), uniform(0.1)), error_of(check(view_of(speck), {.counts_only = true}))}) {
        CHECK(error.code == ErrorCode::empty_mesh);
        CHECK(error.message == reason);
    }
    CHECK(error_of(check(view_of(speck))).code == ErrorCode::empty_mesh);
    const shapes::Soup half = shapes::joined({speck, shapes::box({0, 0, 0}, {1, 1, 1})});
    CHECK(slice(view_of(half), uniform(0.1)).ok());
}

TEST_CASE("a diagonal under 2^20 units is too coarse a grid, whether or not a finer one fits", "[engine][unit]") {
    CHECK(scale_of(0, 0.57, Number::f32).coarse_grid);        // a diagonal of 0.987 mm
    CHECK_FALSE(scale_of(0, 0.58, Number::f32).coarse_grid);  // of 1.005 mm
    CHECK(scale_of(0, 100, Number::f64, 1e-3).coarse_grid);
    CHECK(scale_of(1000, 0.5, Number::f64).coarse_grid);
    CHECK(scale_of(1000, 0.5, Number::f64).finest_grid_mm == default_grid_mm);  // none finer reaches 1,000 mm
    CHECK(scale_of(0, 0.013, Number::f32).finest_grid_mm == 0x1p-36);
}

TEST_CASE("a number step above a tenth of the layer height is lost precision", "[engine][unit]") {
    CHECK_FALSE(scale_of(5000, 2, Number::f32).coarse_numbers);
    CHECK(scale_of(5000, 2, Number::f32).number_step_mm == 0x1p-11);
    CHECK(scale_of(3e5, 2, Number::f32).coarse_numbers);  // steps of 1/32 mm, layers of 0.2
    const Box far{{5000, 0, 0}, {5002, 2, 2}};
    CHECK(judge_scale(far, Number::f32, 0x1p-20, 0.004).coarse_numbers);  // the step is 0.00049 mm
    CHECK_FALSE(judge_scale(far, Number::f32, 0x1p-20, 0.005).coarse_numbers);
    CHECK_FALSE(scale_of(3e5, 2, Number::f64).coarse_numbers);
}

TEST_CASE("boundary edges are counted on the grid and by exact coordinates", "[engine][unit]") {
    shapes::Soup cube = shapes::box({0, 0, 0}, {2, 2, 2});
    for (const auto& [first, exact] : {std::pair(-0.0, 0U), std::pair(1e-9, 4U)}) {  // the same number, one on the grid
        cube[0] = first;
        const MeshCheck found = value_of(check(view_of(cube), {.counts_only = true}));
        CHECK(found.boundary_edges == 0);
        CHECK(found.exact_boundary_edges == exact);
    }
}

TEST_CASE("a unit too fine for the mesh is doubled on request, and the result says how often", "[engine][unit]") {
    const shapes::Soup small = box({0, 0, 0}, {4, 4, 4});
    const shapes::Soup large = box({0, 0, 0}, {4, 4, 3000});
    SliceOptions options = at_heights({2});
    for (const double bad : {-0.5, std::nan("")}) {
        options.frame.grid_mm = bad;
        CHECK(failure_of(view_of(large), options).code == ErrorCode::invalid_argument);
    }
    options.frame.grid_mm = 1e-6;
    CHECK(failure_of(view_of(large), options).code == ErrorCode::bad_coordinate);
    const std::uint64_t fitting = sliced(small, options).hash();
    options.frame.coarser_if_needed = true;
    const SliceResult kept = sliced(small, options);
    CHECK(kept.info.grid_mm == 1e-6);
    CHECK(kept.info.grid_doublings == 0);
    CHECK(kept.hash() == fitting);
    const SliceResult coarser = sliced(large, options);  // 1,073.7 mm fit 1e-6, and 4,294 mm four times as much
    CHECK(coarser.info.grid_mm == 4e-6);
    CHECK(coarser.info.grid_doublings == 2);
    options.frame.coarser_if_needed = false;
    options.frame.grid_mm = 4e-6;
    CHECK(sliced(large, options).hash() == coarser.hash());
    options.frame.grid_mm = 0;
    CHECK(sliced(small, options).info.grid_doublings == 0);
    CHECK(sliced(large, options).info.grid_doublings == 2);
}

TEST_CASE("empty parts take their place among others, and choose no planes", "[engine][empty][parts]") {
    const shapes::Soup nothing;
    const shapes::Soup collapsed = {0, 0, 0, 0, 0, 0, 0, 0, 10, 5, 5, 0, 5, 5, 10, 5, 5, 10};  // each along a line
    const shapes::Soup soup = box({1, 1, 1}, {4, 4, 4});
    const std::vector<Part> parts = {{.mesh = view_of(nothing)}, {.mesh = view_of(soup)}, {.mesh = view_of(nothing)}};
    SliceOptions options = uniform(1);
    CHECK(failure_of(parts, options).code == ErrorCode::empty_mesh);
    options.allow_empty = true;
    const SliceResult result = sliced(parts, options);
    REQUIRE(result.layers.size() == 3);
    CHECK(result.contours.size() == 3);
    CHECK(result.contours[0].part == 1);
    CHECK(result.info.box.min_mm[0] == 1);
    CHECK(result.info.part_count == 3);
    const std::vector<Part> none = {{.mesh = view_of(nothing)}, {.mesh = view_of(collapsed)}};
    options.region.fill_rule = FillRule::non_zero;
    for (const bool united : {false, true}) {
        options.unite_parts = united;
        options.heights_mm.reset();
        CHECK(sliced(none, options).layers.empty());
        options.heights_mm = {{3, 1}};
        CHECK(sliced(none, options).layers.size() == 2);
    }
}

TEST_CASE("results known to be too large are refused before they are allocated", "[engine][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 100});
    CountingMemory memory;
    SliceOptions options = uniform(0.00001);
    const auto limited_to = [&](std::uint64_t bytes) {
        return code_of(slice(view_of(soup), options, {.memory = &memory, .memory_limit_bytes = bytes}));
    };
    CHECK(limited_to(std::uint64_t{1} << 28) == ErrorCode::result_too_large);
    CHECK(memory.peak() < std::size_t{1} << 26);
    CHECK(memory.held() == 0);
    // The layers fit in the limit, but their points do not.
    options.layer_height_mm = 0.001;
    CHECK(limited_to(11'000'000) == ErrorCode::result_too_large);
    // Layers and points fit, but not one contour in each layer too.
    const std::uint64_t layers = 100'000;
    const std::uint64_t bytes = layers * (sizeof(Layer) + 8 * sizeof(Point) + sizeof(Contour));
    CHECK(limited_to(bytes - 1) == ErrorCode::result_too_large);
    CHECK(sliced(view_of(soup), options, {.memory_limit_bytes = bytes}).contours.size() == layers);
    options.origins = true;
    CHECK(limited_to(bytes) == ErrorCode::result_too_large);
    CHECK(limited_to(bytes + layers * 8 * sizeof(PointOrigin)) == std::nullopt);
}

TEST_CASE("the default limit is half of physical memory", "[engine][errors]") {
    constexpr double height_mm = 240;
    constexpr double layer_height_mm = 2.5e-7;
    constexpr double layers_bytes = height_mm / layer_height_mm * sizeof(Layer);
    const double limit_bytes = 0.5 * static_cast<double>(physical_memory_bytes());
    if (limit_bytes > layers_bytes) {
        WARN("not tested: this machine has memory for the most layers that a grid holds");
        return;
    }
    const shapes::Soup soup = shapes::box({0, 0, -height_mm / 2}, {4, 4, height_mm / 2});
    const Error error = failure_of(view_of(soup), uniform(layer_height_mm, 0x1p-23));
    CHECK(error.code == ErrorCode::result_too_large);
    CHECK_THAT(error.message, Catch::Contains(std::to_string(static_cast<std::uint64_t>(limit_bytes))));
}

}  // namespace
