// Where planes lie: spacing, rounding, side, and refused plans; and which layer each of explicit heights gets.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/parts.hpp"
#include "oracle/compare.hpp"

using lamella::CoordinateType;
using lamella::Datum;
using lamella::ErrorCode;
using lamella::Layer;
using lamella::PlaneSide;
using lamella::SliceOptions;
using lamella::SliceResult;
using shapes::box;

namespace {

std::vector<std::int32_t> planes_of(const lamella::SliceResult& result) {
    std::vector<std::int32_t> planes;
    for (const lamella::Layer& layer : result.layers) {
        planes.push_back(layer.plane.z());
    }
    return planes;
}

using Planes = std::vector<std::int32_t>;
using Layers = std::vector<std::uint64_t>;

Layers layers_of(const lamella::SliceResult& result) {
    return {result.layer_of.begin(), result.layer_of.end()};
}

lamella::UniformLayers& uniform_of(lamella::SliceOptions& options) {
    return std::get<lamella::UniformLayers>(options.plan.spacing);
}

/// Boxes side by side: box k of 1..count extends from `low(k)` to `high(k)`.
template <class Height>
shapes::Soup row_of_boxes(int count, Height low, Height high) {
    shapes::Soup soup;
    for (int k = 1; k <= count; ++k) {
        shapes::append(soup, box({2.0 * k, 0, low(k)}, {2.0 * k + 1, 1, high(k)}));
    }
    return soup;
}

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

TEST_CASE("uniform planes lie in the middle of their layers", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 10}, {4, 4, 14});
    const lamella::SliceResult result = sliced(soup, uniform(2, coarse_unit_mm));
    CHECK(planes_of(result) == Planes{21, 25});
    CHECK(result.layers[0].bottom_mm == 10);
    CHECK(result.layers[0].plane_mm == 11);
    CHECK(result.layers[0].top_mm == 12);
    CHECK(result.layers[1].bottom_mm == 12);
    CHECK(result.layers[1].top_mm == 14);
}

TEST_CASE("the first height counts from the datum", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 1}, {4, 4, 8});
    lamella::SliceOptions options = uniform(3, coarse_unit_mm);
    uniform_of(options).first_height_mm = 1;
    CHECK(planes_of(sliced(soup, options)) == Planes{3, 9, 15});
    uniform_of(options).datum = Datum::zero;
    CHECK(planes_of(sliced(soup, options)) == Planes{7, 13});
    options.plan.side = PlaneSide::above;
    CHECK(planes_of(sliced(soup, options)) == Planes{3, 9, 15});
}

TEST_CASE("planes are strictly inside the mesh", "[engine][planes]") {
    lamella::SliceOptions options = uniform(1, coarse_unit_mm);
    uniform_of(options).first_height_mm = 1;
    CHECK(planes_of(sliced(box({0, 0, 0}, {4, 4, 4}), options)) == Planes{1, 3, 5, 7});
    options.plan.side = PlaneSide::above;
    CHECK(planes_of(sliced(box({0, 0, 0}, {4, 4, 4}), options)) == Planes{3, 5, 7});
}

TEST_CASE("a mesh that no plane cuts gives an empty result", "[engine][planes]") {
    CHECK(sliced(box({0, 0, 0}, {4, 4, 1}), uniform(10)).layers.empty());
}

TEST_CASE("explicit heights outside the mesh give empty layers", "[engine][planes]") {
    const lamella::SliceResult result = sliced(box({0, 0, 0}, {4, 4, 4}), at_heights({-1e6, -3, 2, 5, 7, 1e8}));
    REQUIRE(result.layers.size() == 6);
    for (const std::size_t l : {0U, 1U, 3U, 4U, 5U}) {
        CHECK(result.layers[l].contour_count == 0);
        CHECK(result.layers[l].segments == 0);
    }
    CHECK(result.layers[2].contour_count == 1);
    CHECK(result.layers[2].bottom_mm == -0.5);
    CHECK(result.layers[2].top_mm == 3.5);
    CHECK(result.layers[1].plane.z() == -7);
}

TEST_CASE("explicit heights that are not finite name the first", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 4});
    const lamella::Error error = failure_of(view_of(soup), at_heights({3, 1, std::nan(""), 2, -std::nan("")}));
    CHECK(error.code == ErrorCode::bad_planes);
    CHECK(error.plane == 2);
    CHECK(failure_of(view_of(soup), at_heights({1, INFINITY})).plane == 1);
}

TEST_CASE("flat faces at every plane height are always on the same side", "[engine][planes]") {
    constexpr int count = 50;
    // Tops, then undersides, at 0.1, 0.2, ... mm, which binary numbers cannot represent exactly.
    const auto at = [](int k) { return 0.1 * k; };
    const shapes::Soup standing = row_of_boxes(
        count, +[](int) { return -1.0; }, +[](int k) { return 0.1 * k; });
    const shapes::Soup hanging = row_of_boxes(
        count, +[](int k) { return 0.1 * k; }, +[](int) { return 6.0; });
    const bool in_float = GENERATE(true, false);
    const bool is_uniform = GENERATE(true, false);
    const PlaneSide side = GENERATE(PlaneSide::below, PlaneSide::above);
    lamella::SliceOptions options = at_heights({});
    options.unit_mm = 0;
    options.plan.side = side;
    if (is_uniform) {
        options.plan.spacing = lamella::UniformLayers{0.1, 0.0, Datum::zero};
    } else {
        auto& heights = std::get<lamella::ExplicitPlanes>(options.plan.spacing).heights_mm;
        for (int k = 0; k <= count; ++k) {
            heights.push_back(at(k));
        }
    }
    const auto outers = [&](const shapes::Soup& soup) {
        const std::vector<float> rounded = shapes::floats(soup);
        return sliced(in_float ? lamella::MeshView::soup(std::span<const float>(rounded)) : view_of(soup), options);
    };
    const lamella::SliceResult tops = outers(standing);
    const lamella::SliceResult undersides = outers(hanging);
    // Layer k cuts the boxes with their top above it. With planes below, it also cuts boxes with their top at its height.
    const int missing_tops = side == PlaneSide::below ? 1 : 0;
    for (int k = 1; k <= count; ++k) {
        INFO("height " << k << ", side " << (side == PlaneSide::below ? "below" : "above"));
        const auto layer_at = [&](const lamella::SliceResult& result) -> const lamella::Layer* {
            for (const lamella::Layer& layer : result.layers) {
                if (std::abs(layer.plane_mm - at(k)) < 1e-9) {
                    return &layer;
                }
            }
            return nullptr;
        };
        const lamella::Layer* top = layer_at(tops);
        const int standing_there = count - k + missing_tops;
        CHECK((top == nullptr ? 0 : static_cast<int>(top->contour_count)) == standing_there);
        const lamella::Layer* underside = layer_at(undersides);
        CHECK((underside == nullptr ? 0 : static_cast<int>(underside->contour_count)) == k - missing_tops);
    }
}

TEST_CASE("every plane is rounded from its exact height", "[engine][planes]") {
    // Steps are a third of a millimetre. Adding rounded steps would drift by hundreds of units.
    const lamella::SliceResult result = sliced(box({0, 0, 0}, {1, 1, 1000}), uniform(1.0 / 3));
    REQUIRE(result.layers.size() == 3000);
    for (std::size_t i = 0; i < result.layers.size(); ++i) {
        const double height = (static_cast<double>(i) + 0.5) / 3;
        const double cut = result.layers[i].plane.z() * result.unit_mm;
        REQUIRE(std::abs(height - cut) <= 2.5 * result.unit_mm);
    }
}

TEST_CASE("a plane is cut within half a number step and two units of the height asked for", "[engine][planes]") {
    const double low = GENERATE(0.3, 7.9, 100.7, 700.1);
    const shapes::Soup mesh = box({0, 0, low}, {1, 1, low + 3.3});
    const std::vector<float> floats(mesh.begin(), mesh.end());
    lamella::SliceOptions options = uniform(0.0137);
    options.plan.side = GENERATE(PlaneSide::below, PlaneSide::above);
    const double toward = options.plan.side == PlaneSide::below ? -1 : 1;
    double farthest_units = 0;
    for (const bool as_floats : {false, true}) {
        const auto view = as_floats ? lamella::MeshView::soup(std::span<const float>(floats)) : view_of(mesh);
        const lamella::SliceResult cut = value_of(slice(view, options));
        const lamella::SliceResult& result = cut;
        REQUIRE(result.layers.size() > 200);
        for (const lamella::Layer& layer : result.layers) {
            const double asked = layer.plane_mm;
            const double step = as_floats ? std::nextafter(static_cast<float>(asked), 1e9F) - static_cast<float>(asked) : 0;
            const double moved_units = (result.to_mm(layer.plane) - asked) / result.unit_mm;
            CHECK(std::abs(moved_units - toward) <= step / 2 / result.unit_mm + 1.001);
            farthest_units = std::max(farthest_units, std::abs(moved_units));
        }
    }
    CHECK(farthest_units > (low > 512 ? 20 : 1));  // at 700 mm the bound of two units does not hold for floats
}

TEST_CASE("facets that end within a unit of uniform planes are cut by the right planes", "[engine][planes]") {
    // Slivers that begin and end next to planes, where division alone would be off by one.
    shapes::Soup soup = box({0, 0, 0}, {1, 1, 30});
    for (int i = 1; i < 290; ++i) {
        for (const double nudge : {-2e-6, 0.0, 2e-6}) {
            const double low = 0.1 * i + nudge;
            const double high = 0.1 * (i + 1 + i % 3) + nudge;
            shapes::append(soup, shapes::triangle({2.0, 0, low}, {3, 0.5, low}, {2, i * 1e-3, high}));
        }
    }
    for (const double first : {0.1, 0.05}) {
        lamella::SliceOptions options = uniform(0.1);
        uniform_of(options).first_height_mm = first;
        const lamella::SliceResult result = sliced(soup, options);
        CHECK(result.layers.size() >= 299);
        CHECK_THAT(oracle::difference(result, oracle::quantise(soup, result.unit_mm)), Catch::Equals(""));
    }
}

TEST_CASE("random heights stay between their bounds and repeat by seed", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 5}, {1, 1, 25});
    lamella::SliceOptions options;
    options.plan.spacing = lamella::RandomLayers{0.016, 0.032, 7};
    const lamella::SliceResult result = sliced(soup, options);
    REQUIRE(result.layers.size() > 625);
    REQUIRE(result.layers.size() < 1250);
    double below = 5;
    double least = 1;
    double most = 0;
    for (const lamella::Layer& layer : result.layers) {
        least = std::min(least, layer.plane_mm - below);
        most = std::max(most, layer.plane_mm - below);
        below = layer.plane_mm;
    }
    CHECK(least >= 0.016 - 1e-9);
    CHECK(most <= 0.032 + 1e-9);
    CHECK(most - least > 0.015);
    CHECK(hash_result(sliced(soup, options)) == hash_result(result));
    options.plan.spacing = lamella::RandomLayers{0.016, 0.032, 8};
    CHECK(hash_result(sliced(soup, options)) != hash_result(result));
}

TEST_CASE("steps under two units and too many planes are refused", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 100});
    CHECK(failure_of(view_of(soup), uniform(0.9, coarse_unit_mm)).code == ErrorCode::bad_planes);
    CHECK(failure_of(view_of(soup), uniform(1e-12)).code == ErrorCode::bad_planes);
    lamella::SliceOptions random;
    random.plan.spacing = lamella::RandomLayers{1e-7, 1e-3, 1};
    CHECK(failure_of(view_of(soup), random).code == ErrorCode::bad_planes);
    CHECK(failure_of(view_of(soup), uniform(0)).code == ErrorCode::invalid_argument);
    CHECK(failure_of(view_of(soup), uniform(-1)).code == ErrorCode::invalid_argument);
    CHECK(failure_of(view_of(soup), uniform(std::nan(""))).code == ErrorCode::invalid_argument);
    random.plan.spacing = lamella::RandomLayers{2, 1, 1};
    CHECK(failure_of(view_of(soup), random).code == ErrorCode::invalid_argument);
}

TEST_CASE("uniform planes that floats cannot tell apart name the pair", "[engine][planes]") {
    const std::vector<float> mesh = shapes::floats(box({0, 0, 700}, {1, 1, 700.01}));
    const lamella::Error error = failure_of(lamella::MeshView::soup(std::span<const float>(mesh)), uniform(1e-5));
    CHECK(error.code == ErrorCode::bad_planes);
    CHECK(error.plane == 1);
    CHECK_THAT(error.message, Catch::Contains("planes 0 and 1 (") && Catch::Contains("the same on the grid"));
}

TEST_CASE("planes far beyond the grid give empty layers", "[engine][planes]") {
    lamella::SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{-2e8, -1e8, -3000, 0.5, 2500, 9e7, 1e8}};
    const lamella::SliceResult result = sliced(shapes::box({0, 0, 0}, {1, 1, 1}), options);
    REQUIRE(result.layers.size() == 7);
    for (std::size_t l = 0; l < 7; ++l) {
        CHECK(result.layers[l].contour_count == (l == 3 ? 1 : 0));
    }
    options.plan.spacing = lamella::ExplicitPlanes{{1e8, 0.5, -1e8, 1e8, 1.5e8, -1e8}};
    const lamella::SliceResult repeated = sliced(shapes::box({0, 0, 0}, {1, 1, 1}), options);
    REQUIRE(repeated.layers.size() == 4);
    CHECK(layers_of(repeated) == Layers{2, 1, 0, 2, 3, 0});
}

TEST_CASE("layers far thicker than the mesh do not cut it", "[engine][planes]") {
    // A half layer is 2,500 mm or more, and the grid ends at 1,024 mm.
    const shapes::Soup soup = box({-1, -1, -1}, {1, 1, 1});
    for (const double layer_mm : {5'000.0, 10'000.0, 1e6, 1e300}) {
        for (const Datum datum : {Datum::mesh_min, Datum::zero}) {
            lamella::SliceOptions options = uniform(layer_mm);
            uniform_of(options).datum = datum;
            CHECK(planes_of(sliced(soup, options)).empty());
        }
    }
}

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
