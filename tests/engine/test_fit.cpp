// Meshes that do not fit the unit asked for, and meshes of nothing.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/parts.hpp"

using lamella::ErrorCode;
using lamella::MeshView;
using lamella::Part;
using lamella::SliceOptions;
using lamella::SliceResult;
using lamella::UnitFit;
using shapes::box;

namespace {

/// Two triangles, each along a line, from z = 0 to 10.
shapes::Soup lines() {
    return {0, 0, 0, 0, 0, 0, 0, 0, 10, 5, 5, 0, 5, 5, 10, 5, 5, 10};
}

SliceOptions allowing(SliceOptions options) {
    options.allow_empty = true;
    return options;
}

}  // namespace

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
    const auto refused = slice_parts(parts, options);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::bad_coordinate);
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
    const auto refused = slice_parts(parts, uniform(1));
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::empty_mesh);
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
