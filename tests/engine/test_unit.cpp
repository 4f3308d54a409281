// The grid's unit, meshes that do not fit the unit asked for, are too small or too far away for their numbers, or are empty.
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/lamella.hpp"
#include "lamella/parts.hpp"

using lamella::CoordinateType;
using lamella::ErrorCode;
using lamella::MeshScale;
using lamella::MeshView;
using lamella::Part;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::UnitFit;
using shapes::box;

namespace {

/// The scale of a box from (low, low, low) to (low + edge, ...), on the default grid unless told otherwise.
MeshScale scale_of(double low, double edge, CoordinateType number, double unit_mm = lamella::default_unit_mm) {
    const double min_mm[3] = {low, low, low};
    const double max_mm[3] = {low + edge, low + edge, low + edge};
    return lamella::judge_scale(min_mm, max_mm, number, unit_mm);
}

/// Two triangles, each along a line, from z = 0 to 10.
shapes::Soup lines() {
    return {0, 0, 0, 0, 0, 0, 0, 0, 10, 5, 5, 0, 5, 5, 10, 5, 5, 10};
}

SliceOptions allowing(SliceOptions options) {
    options.allow_empty = true;
    return options;
}

}  // namespace

TEST_CASE("the unit by box is the finest power of two that the mesh fits", "[engine][unit]") {
    lamella::SliceOptions options;
    options.unit_mm = lamella::unit_by_box;
    for (const double edge : {1e-6, 0.013, 1.0, 3.0, 700.0, 2.5e4, 8e8}) {
        std::get<lamella::UniformLayers>(options.plan.spacing).layer_height_mm = edge / 3;
        const lamella::SliceResult result = sliced(shapes::box({0, 0, 0}, {edge, edge, edge}), options);
        INFO("edge " << edge << " mm, unit " << result.unit_mm);
        CHECK(std::log2(result.unit_mm) == std::round(std::log2(result.unit_mm)));
        CHECK(edge <= result.unit_mm * (lamella::grid_limit - 2));
        CHECK(edge > result.unit_mm / 2 * (lamella::grid_limit - 2));
        REQUIRE(result.layers.size() == 3);
        CHECK(result.area_mm2(result.layers[1]) == Approx(edge * edge).epsilon(1e-8));
    }
}

TEST_CASE("a detail that the default grid loses is found on the unit by box", "[engine][unit]") {
    // The second box is a tenth of a nanometre thick.
    const shapes::Soup soup = shapes::joined(
        {shapes::box({0, 0, 0}, {0.004, 0.004, 0.004}), shapes::box({0.0041, 0, 0}, {0.0041 + 1e-7, 0.004, 0.004})});
    lamella::SliceOptions options = at_heights({0.002});
    options.unit_mm = lamella::default_unit_mm;
    CHECK(sliced(soup, options).summary.degenerate > 0);
    options.unit_mm = lamella::unit_by_box;
    const lamella::SliceResult fine = sliced(soup, options);
    CHECK(fine.summary.degenerate == 0);
    CHECK(fine.contours.size() == 2);
}

TEST_CASE("the unit by box leaves room for what rules move", "[engine][unit]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {0.9995, 0.9995, 0.9995});
    lamella::SliceOptions options = at_heights({0.5});
    options.unit_mm = lamella::unit_by_box;
    CHECK(sliced(cube, options).unit_mm == 0x1p-30);
    options.region.fill_rule = lamella::FillRule::non_zero;
    CHECK(sliced(cube, options).unit_mm == 0x1p-30);
    const auto [offset, close, mark] =
        GENERATE(table<double, double, double>({{0.002, 0, 0}, {0, 0.002, 0}, {0, 0, 0.002}}));
    options.region.offset_mm = offset;
    options.region.close_mm = close;
    options.region.mark_near_mm = mark;
    const lamella::SliceResult grown = sliced(cube, options);
    CHECK(grown.unit_mm == 0x1p-29);
    CHECK(grown.area_mm2(grown.layers[0]) == Approx(std::pow(0.9995 + 2 * offset, 2)));
    // A unit that may be doubled is; one that is asked for is refused.
    options.unit_mm = 0x1p-30;
    CHECK(failure_of(view_of(cube), options).message.find("choose a unit of more than") != std::string::npos);
    options.unit_fit = lamella::UnitFit::coarser_if_needed;
    CHECK(sliced(cube, options).summary.unit_doublings == 1);
}

TEST_CASE("a transform that flattens every mesh is refused, whatever the call", "[engine][unit]") {
    const shapes::Soup cube = shapes::box({0, 0, 0}, {1, 1, 1});
    lamella::SliceOptions options = uniform(0.1);
    auto& m = options.transform.m;
    m = GENERATE(std::array<double, 12>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0},
                 std::array<double, 12>{1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 1});
    CHECK(options.transform.is_singular());
    const lamella::Error error = failure_of(view_of(cube), options);
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.message.find("singular") != std::string::npos);
    CHECK(inspect(view_of(cube), {.transform = options.transform}).error().message == error.message);
    CHECK(prepare(view_of(cube), {.transform = options.transform}).error().message == error.message);
    for (const double small : {1e-9, -1e-3, 1e6}) {
        CHECK_FALSE(lamella::Transform::scale(small).is_singular());
    }
    m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1e-9, 0};
    CHECK_FALSE(options.transform.is_singular());
}

TEST_CASE("a mesh of which every triangle collapses is empty", "[engine][unit]") {
    const shapes::Soup speck = shapes::box({5, 5, 5}, {5 + 1e-9, 5 + 1e-9, 5 + 1e-9});
    const std::string reason = "each of 12 triangles has two equal corners on the grid of 9.5367431640625e-07 mm";
    for (const lamella::Error& error : {failure_of(view_of(speck), uniform(0.1)), error_of(inspect(view_of(speck)))}) {
        CHECK(error.code == ErrorCode::empty_mesh);
        CHECK(error.message == reason);
    }
    CHECK(error_of(lamella::check(view_of(speck))).code == ErrorCode::empty_mesh);
    const shapes::Soup half = shapes::joined({speck, shapes::box({0, 0, 0}, {1, 1, 1})});
    CHECK(slice(view_of(half), uniform(0.1)).ok());
}

TEST_CASE("a diagonal under 2^20 units is too coarse a grid, whether or not a finer one fits", "[engine][unit]") {
    CHECK(scale_of(0, 0.57, CoordinateType::f32).coarse_grid);        // a diagonal of 0.987 mm
    CHECK_FALSE(scale_of(0, 0.58, CoordinateType::f32).coarse_grid);  // of 1.005 mm
    CHECK(scale_of(0, 100, CoordinateType::f64, 1e-3).coarse_grid);
    CHECK(scale_of(1000, 0.5, CoordinateType::f64).coarse_grid);
    CHECK(scale_of(1000, 0.5, CoordinateType::f64).finest_unit_mm ==
          lamella::default_unit_mm);  // none finer reaches 1,000 mm
    CHECK(scale_of(0, 0.013, CoordinateType::f32).finest_unit_mm == 0x1p-36);
}

TEST_CASE("a number step above a tenth of the layer height is lost precision", "[engine][unit]") {
    CHECK_FALSE(scale_of(5000, 2, CoordinateType::f32).coarse_numbers);
    CHECK(scale_of(5000, 2, CoordinateType::f32).number_step_mm == 0x1p-11);
    CHECK(scale_of(3e5, 2, CoordinateType::f32).coarse_numbers);  // steps of 1/32 mm, layers of 0.2
    const double low[3] = {5000, 0, 0};
    const double high[3] = {5002, 2, 2};
    CHECK(lamella::judge_scale(low, high, CoordinateType::f32, 0x1p-20, 0.004).coarse_numbers);  // the step is 0.00049 mm
    CHECK_FALSE(lamella::judge_scale(low, high, CoordinateType::f32, 0x1p-20, 0.005).coarse_numbers);
    CHECK_FALSE(scale_of(3e5, 2, CoordinateType::f64).coarse_numbers);
}

TEST_CASE("boundary edges are counted on the grid and by exact coordinates", "[engine][unit]") {
    using Counts = std::pair<std::uint64_t, std::uint64_t>;
    const auto counts = [](const lamella::MeshView& mesh) {
        const lamella::MeshInfo info = value_of(inspect(mesh));
        return Counts(info.boundary_edges, info.exact_boundary_edges);
    };
    shapes::Soup cube = shapes::box({1, 1, 1}, {2, 2, 2});
    CHECK(counts(view_of(cube)) == Counts(0, 0));
    cube[0] += 1e-9;  // the grid joins the corner of this triangle to the others
    CHECK(counts(view_of(cube)) == Counts(0, 4));
    cube.resize(cube.size() - 9);
    CHECK(counts(view_of(cube)).first == 3);
    CHECK(counts(view_of(cube)).second > 3);

    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 3, 3);
    std::vector<float> floats(ball.begin(), ball.end());
    const auto view = [&] { return lamella::MeshView::soup(std::span<const float>(floats)); };
    CHECK(counts(view()) == Counts(0, 0));
    const auto zero = std::find(floats.begin(), floats.end(), 0.0F);
    REQUIRE(zero != floats.end());
    *zero = -0.0F;  // the same number
    CHECK(counts(view()) == Counts(0, 0));
    const auto small = std::find_if(floats.begin(), floats.end(), [](float x) { return x > 0 && x < 1; });
    REQUIRE(small != floats.end());
    *small = std::nextafter(*small, 1.0F);
    CHECK(counts(view()) == Counts(0, 4));
}

TEST_CASE("a unit too fine for the mesh is doubled on request, and the result says how often", "[engine][unit]") {
    const shapes::Soup small = box({0, 0, 0}, {4, 4, 4});
    const shapes::Soup large = box({0, 0, 0}, {4, 4, 3000});
    SliceOptions options = at_heights({2});
    options.unit_mm = 1e-6;
    CHECK(failure_of(view_of(large), options).code == ErrorCode::bad_coordinate);
    const std::uint64_t fitting = hash_result(sliced(small, options));
    options.unit_fit = UnitFit::coarser_if_needed;
    const SliceResult kept = sliced(small, options);
    CHECK(kept.unit_mm == 1e-6);
    CHECK(kept.summary.unit_doublings == 0);
    CHECK(hash_result(kept) == fitting);
    const SliceResult coarser = sliced(large, options);  // 1,073.7 mm fit 1e-6, and 4,294 mm four times as much
    CHECK(coarser.unit_mm == 4e-6);
    CHECK(coarser.summary.unit_doublings == 2);
    options.unit_fit = UnitFit::as_asked;
    options.unit_mm = 4e-6;
    CHECK(hash_result(sliced(large, options)) == hash_result(coarser));
    options.unit_mm = 0;
    CHECK(sliced(small, options).summary.unit_doublings == 0);
    CHECK(sliced(large, options).summary.unit_doublings == 2);
}

TEST_CASE("the unit of parts is doubled for the box of all", "[engine][unit][parts]") {
    const shapes::Soup small = box({0, 0, 0}, {4, 4, 4});
    const shapes::Soup large = box({0, 0, 0}, {4, 4, 3000});
    const std::vector<Part> parts = {{.mesh = view_of(small)}, {.mesh = view_of(large)}};
    SliceOptions options = at_heights({2});
    options.unit_mm = 1e-6;
    CHECK(error_of(slice_parts(parts, options)).code == ErrorCode::bad_coordinate);
    options.unit_fit = UnitFit::coarser_if_needed;
    const auto result = value_of(slice_parts(parts, options));
    CHECK(result.unit_mm == 4e-6);
    CHECK(result.summary.unit_doublings == 2);
    CHECK(result.contours.size() == 2);
}

TEST_CASE("a unit that is none is refused however it may be fitted", "[engine][unit][errors]") {
    SliceOptions options = at_heights({2});
    options.unit_fit = UnitFit::coarser_if_needed;
    for (const double unit : {-3.0, 1e-16, 1e10}) {
        options.unit_mm = unit;
        CHECK(failure_of(view_of(box({0, 0, 0}, {4, 4, 4})), options).code == ErrorCode::invalid_argument);
    }
}

TEST_CASE("an empty mesh gives empty layers at given heights and no others, where allowed", "[engine][empty]") {
    const shapes::Soup nothing;
    const shapes::Soup collapsed = lines();
    for (const shapes::Soup* soup : {&nothing, &collapsed}) {
        CHECK(failure_of(view_of(*soup), at_heights({2})).code == ErrorCode::empty_mesh);
        const SliceResult given = sliced(*soup, allowing(at_heights({5, 2, 5})));
        REQUIRE(given.layers.size() == 2);
        CHECK(given.layers[0].plane_mm == 2);
        CHECK(given.layers[0].contour_count == 0);
        CHECK(given.layer_of[0] == 1);
        CHECK(given.layer_of[1] == 0);
        CHECK(given.points.empty());
        CHECK(given.summary.triangles == soup->size() / 9);
        CHECK(given.summary.degenerate == soup->size() / 9);
        CHECK(sliced(*soup, allowing(uniform(1))).layers.empty());
        SliceOptions random = allowing(uniform(1));
        random.plan.spacing = lamella::RandomLayers{1, 2, 3};
        CHECK(sliced(*soup, random).layers.empty());
        CHECK(failure_of(view_of(*soup), allowing(uniform(-1))).code == ErrorCode::invalid_argument);
    }
}

TEST_CASE("allowing empty meshes changes nothing of others", "[engine][empty]") {
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 4});
    CHECK(hash_result(sliced(soup, allowing(uniform(1)))) == hash_result(sliced(soup, uniform(1))));
    lamella::Workspace workspace;
    SliceResult result;
    REQUIRE(slice(view_of(soup), allowing(uniform(1)), workspace, result).ok());
    REQUIRE(slice(view_of({}), allowing(uniform(1)), workspace, result).ok());
    CHECK(result.layers.empty());
    REQUIRE(slice(view_of(soup), allowing(uniform(1)), workspace, result).ok());
    CHECK(hash_result(result) == hash_result(sliced(soup, uniform(1))));
}

TEST_CASE("empty parts take their place among others, and choose no planes", "[engine][empty][parts]") {
    const shapes::Soup nothing;
    const shapes::Soup collapsed = lines();
    const shapes::Soup soup = box({1, 1, 1}, {4, 4, 4});
    const std::vector<Part> parts = {{.mesh = view_of(nothing)}, {.mesh = view_of(soup)}, {.mesh = view_of(nothing)}};
    CHECK(error_of(slice_parts(parts, uniform(1))).code == ErrorCode::empty_mesh);
    const auto result = value_of(slice_parts(parts, allowing(uniform(1))));
    REQUIRE(result.layers.size() == 3);
    CHECK(result.contours.size() == 3);
    CHECK(result.contours[0].part == 1);
    CHECK(result.summary.min_mm[0] == 1);
    CHECK(result.part_count == 3);
    const std::vector<Part> none = {{.mesh = view_of(nothing)}, {.mesh = view_of(collapsed)}};
    for (const auto regions : {lamella::PartRegions::separate, lamella::PartRegions::united}) {
        SliceOptions options = allowing(uniform(1));
        options.region.fill_rule = lamella::FillRule::non_zero;
        const auto empty = value_of(slice_parts(none, options, regions));
        CHECK(empty.layers.empty());
        options.plan = at_heights({3, 1}).plan;
        const auto layers = value_of(slice_parts(none, options, regions));
        CHECK(layers.layers.size() == 2);
    }
}
