// Explicit heights in any order: which layer each of them gets.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/parts.hpp"

using lamella::CoordinateType;
using lamella::Layer;
using lamella::PlaneSide;
using lamella::SliceOptions;
using lamella::SliceResult;
using shapes::box;

namespace {

/// The plane of a height, by the rule as planes.hpp states it.
std::int64_t plane_of(double height_mm, double unit_mm, PlaneSide side, CoordinateType number) {
    const double rounded = number == CoordinateType::f32 ? double{static_cast<float>(height_mm)} : height_mm;
    return 2 * static_cast<std::int64_t>(std::nearbyint(rounded / (2 * unit_mm))) + (side == PlaneSide::below ? -1 : 1);
}

/// Each height's own layer, and every layer's height, by comparing all planes.
void check_layers(const SliceResult& result, CoordinateType number) {
    const std::vector<double>& heights = std::get<lamella::ExplicitPlanes>(result.plan.spacing).heights_mm;
    std::map<std::int64_t, double> least;  // by plane
    for (const double mm : heights) {
        const std::int64_t plane = plane_of(mm, result.unit_mm, result.plan.side, number);
        const auto [at, fresh] = least.try_emplace(plane, mm);
        at->second = std::min(at->second, mm);
    }
    REQUIRE(result.layers.size() == least.size());
    std::size_t l = 0;
    for (const auto& [plane, mm] : least) {
        CHECK(result.layers[l].plane.z() == plane);
        CHECK(result.layers[l++].plane_mm == mm);
    }
    REQUIRE(result.layer_of.size() == heights.size());
    for (std::size_t i = 0; i < heights.size(); ++i) {
        REQUIRE(result.layer_of[i] < result.layers.size());
        CHECK(result.layers[result.layer_of[i]].plane.z() == plane_of(heights[i], result.unit_mm, result.plan.side, number));
    }
}

/// Some of the range, of which a third are repeated or lie within a few units of another.
std::vector<double> drawn_heights(std::mt19937& random, double unit_mm) {
    std::uniform_real_distribution<double> anywhere(-1, 11);
    std::uniform_int_distribution<int> nudge(-8, 8);
    std::vector<double> heights;
    for (auto count = std::uniform_int_distribution<int>(1, 60)(random); count > 0; --count) {
        heights.push_back(anywhere(random));
        if (count % 3 == 0) {
            heights.push_back(heights[random() % heights.size()] + nudge(random) * unit_mm / 4);
        }
    }
    std::shuffle(heights.begin(), heights.end(), random);
    return heights;
}

}  // namespace

TEST_CASE("every height has the layer of its plane, whatever their order", "[engine][planes][threads]") {
    std::mt19937 random(13);
    const shapes::Soup soup = shapes::octasphere({5, 5, 5}, 5, 3);
    const std::vector<float> floats = shapes::floats(soup);
    for (int round = 0; round < 60; ++round) {
        const bool as_floats = round % 2 == 0;
        const auto mesh = as_floats ? lamella::MeshView::soup(std::span<const float>(floats)) : view_of(soup);
        SliceOptions options;
        options.unit_mm = round % 3 == 0 ? 1e-6 : 0x1p-10;
        options.plan.side = round % 4 < 2 ? PlaneSide::below : PlaneSide::above;
        std::vector<double> heights = drawn_heights(random, options.unit_mm);
        options.plan.spacing = lamella::ExplicitPlanes{heights};
        options.control.threads = 1 + round % 3;
        const SliceResult result = sliced(mesh, options);
        check_layers(result, as_floats ? CoordinateType::f32 : CoordinateType::f64);
        std::sort(heights.begin(), heights.end());
        options.plan.spacing = lamella::ExplicitPlanes{heights};
        options.control.threads = 3 - round % 3;
        const SliceResult sorted = sliced(mesh, options);
        CHECK(hash_result(sorted) == hash_result(result));
        CHECK(std::is_sorted(sorted.layer_of.begin(), sorted.layer_of.end()));
    }
}

TEST_CASE("heights on one plane share the layer of the least", "[engine][planes]") {
    const SliceResult result = sliced(box({0, 0, 0}, {4, 4, 4}), at_heights({3, 1.75, 1, 2.25, 3, 2}));
    REQUIRE(result.layers.size() == 3);
    CHECK(result.layers[1].plane_mm == 1.75);
    CHECK(result.layers[1].plane.z() == 3);
    CHECK(result.layers[1].bottom_mm == (1 + 1.75) / 2);
    CHECK(result.layers[1].top_mm == (1.75 + 3) / 2);
    CHECK(std::vector<std::uint64_t>(result.layer_of.begin(), result.layer_of.end()) ==
          std::vector<std::uint64_t>{2, 1, 0, 1, 2, 1});
}

TEST_CASE("only explicit heights have layers by height, and a used result forgets them", "[engine][planes]") {
    lamella::Workspace workspace;
    SliceResult result;
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 4});
    REQUIRE(slice(view_of(soup), at_heights({2, 1, 2}), workspace, result).ok());
    CHECK(result.layer_of.size() == 3);
    REQUIRE(slice(view_of(soup), uniform(1), workspace, result).ok());
    CHECK(result.layer_of.empty());
    REQUIRE(slice(view_of(soup), at_heights({}), workspace, result).ok());
    CHECK(result.layer_of.empty());
}

TEST_CASE("parts share the layers of explicit heights", "[engine][planes][parts]") {
    const shapes::Soup low = box({0, 0, 0}, {4, 4, 4});
    const shapes::Soup high = box({2, 2, 1}, {6, 6, 6});
    const std::vector<lamella::Part> parts = {{.mesh = view_of(low)}, {.mesh = view_of(high)}};
    SliceOptions options = at_heights({5, 1, 3, 5, 1.1});
    options.region.fill_rule = lamella::FillRule::non_zero;
    for (const auto regions : {lamella::PartRegions::separate, lamella::PartRegions::united}) {
        const auto result = value_of(slice_parts(parts, options, regions));
        check_layers(result, CoordinateType::f64);
    }
}

TEST_CASE("layers by height count towards the memory limit", "[engine][planes][errors]") {
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 4});
    SliceOptions options = at_heights(std::vector<double>(10000, 2.0));
    options.memory_limit_bytes = 10000;
    CHECK(failure_of(view_of(soup), options).code == lamella::ErrorCode::result_too_large);
    options.memory_limit_bytes = 90000;
    CHECK(sliced(soup, options).layers.size() == 1);
}
