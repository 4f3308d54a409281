// Where planes lie: spacing, rounding, side, and refused plans; and which layer each of explicit heights gets.
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "engine/slicing.hpp"

using namespace lamella;
using shapes::box;

namespace {

std::vector<std::int32_t> planes_of(const SliceResult& result) {
    std::vector<std::int32_t> planes;
    for (const Layer& layer : result.layers) {
        planes.push_back(layer.plane.z());
    }
    return planes;
}

using Planes = std::vector<std::int32_t>;
using Layers = std::vector<std::uint64_t>;

Tuning at_random(double least_mm, double most_mm, std::uint64_t seed) {
    return {.random_heights = RandomHeights{least_mm, most_mm, seed}};
}

/// The plane of a height, by the rule as options.hpp states it.
std::int64_t plane_of(double height_mm, double unit_mm, PlaneSide side, Number number) {
    const double rounded = number == Number::f32 ? double{static_cast<float>(height_mm)} : height_mm;
    return 2 * static_cast<std::int64_t>(std::nearbyint(rounded / (2 * unit_mm))) + (side == PlaneSide::below ? -1 : 1);
}

/// Each height's own layer, and every layer's height, by comparing all planes.
void check_layers(const SliceResult& result, Number number) {
    const std::vector<double>& heights = *result.info.options.heights_mm;
    std::map<std::int64_t, double> least;  // by plane
    for (const double mm : heights) {
        const std::int64_t plane = plane_of(mm, result.info.grid_mm, result.info.options.planes.side, number);
        const auto [at, fresh] = least.try_emplace(plane, mm);
        at->second = std::min(at->second, mm);
    }
    REQUIRE(result.layers.size() == least.size());
    std::size_t l = 0;
    for (const auto& [plane, mm] : least) {
        CHECK(result.layers[l].plane.z() == plane);
        CHECK(result.layers[l].plane_mm == mm);
        if (l > 0) {
            const double middle = (result.layers[l - 1].plane_mm + mm) / 2;
            CHECK(result.layers[l].bottom_mm == middle);
            CHECK(result.layers[l - 1].top_mm == middle);
        }
        ++l;
    }
    REQUIRE(result.info.layer_of.size() == heights.size());
    for (std::size_t i = 0; i < heights.size(); ++i) {
        REQUIRE(result.info.layer_of[i] < result.layers.size());
        CHECK(result.layers[result.info.layer_of[i]].plane.z() ==
              plane_of(heights[i], result.info.grid_mm, result.info.options.planes.side, number));
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

TEST_CASE("uniform planes lie in the middle of their layers or from a first height on, strictly inside the mesh",
          "[engine][planes]") {
    const auto above = PlaneSide::above;
    const std::tuple<double, double, double, PlaneOptions, Planes> cases[] = {
        // where the mesh begins and ends, and the height of layers
        {10, 14, 2, {}, {21, 25}},
        {1, 8, 3, {.first_height_mm = 1}, {3, 9, 15}},
        {1, 8, 3, {.first_height_mm = 1, .datum = Datum::zero}, {7, 13}},
        {1, 8, 3, {.first_height_mm = 1, .datum = Datum::zero, .side = above}, {3, 9, 15}},
        {0, 4, 1, {.first_height_mm = 1}, {1, 3, 5, 7}},
        {0, 4, 1, {.first_height_mm = 1, .side = above}, {3, 5, 7}},
        {0, 1, 10, {}, {}},
    };
    for (const auto& [bottom_mm, top_mm, layer_mm, planes, expected] : cases) {
        const SliceOptions options{.layer_height_mm = layer_mm, .planes = planes, .frame = {.grid_mm = coarse_unit_mm}};
        CHECK(planes_of(sliced(box({0, 0, bottom_mm}, {4, 4, top_mm}), options)) == expected);
    }
    const SliceResult result = sliced(box({0, 0, 10}, {4, 4, 14}), uniform(2, coarse_unit_mm));
    CHECK(result.layers[0].bottom_mm == 10);
    CHECK(result.layers[0].plane_mm == 11);
    CHECK(result.layers[0].top_mm == 12);
    CHECK(result.layers[1].bottom_mm == 12);
    CHECK(result.layers[1].top_mm == 14);
}

TEST_CASE("explicit heights outside the mesh, and far beyond the grid, give empty layers", "[engine][planes]") {
    for (const double grid_mm : {coarse_unit_mm, 0.0}) {
        SliceOptions options = at_heights({-2e8, -3000, 1e8, 2, 5, 7, -3, 1e8, 1.5e8, -2e8}, grid_mm);
        const SliceResult result = sliced(box({0, 0, 0}, {4, 4, 4}), options);
        REQUIRE(result.layers.size() == 8);
        for (std::size_t l = 0; l < 8; ++l) {
            CHECK(result.layers[l].contour_count == (l == 3 ? 1 : 0));
            CHECK((result.layers[l].segments == 0) == (l != 3));
        }
        CHECK(result.layers[3].bottom_mm == -0.5);
        CHECK(result.layers[3].top_mm == 3.5);
        CHECK(result.info.layer_of == Layers{0, 1, 6, 3, 4, 5, 2, 6, 7, 0});
    }
}

TEST_CASE("random heights stay between their bounds and repeat by seed", "[engine][planes]") {
    const shapes::Soup soup = box({0, 0, 5}, {1, 1, 25});
    const SliceResult result = sliced(soup, {}, {}, at_random(0.016, 0.032, 7));
    REQUIRE(result.layers.size() > 625);
    REQUIRE(result.layers.size() < 1250);
    double below = 5;
    double least = 1;
    double most = 0;
    for (const Layer& layer : result.layers) {
        least = std::min(least, layer.plane_mm - below);
        most = std::max(most, layer.plane_mm - below);
        below = layer.plane_mm;
    }
    CHECK(least >= 0.016 - 1e-9);
    CHECK(most <= 0.032 + 1e-9);
    CHECK(most - least > 0.015);
    CHECK(sliced(soup, {}, {}, at_random(0.016, 0.032, 7)).hash() == result.hash());
    CHECK(sliced(soup, {}, {}, at_random(0.016, 0.032, 8)).hash() != result.hash());
    const SliceResult listed = sliced(soup, result.info.options);  // the heights that were drawn
    CHECK(listed.hash() == result.hash());
    CHECK(listed.info.options == result.info.options);
    for (const auto& [least, most, code] :
         {std::tuple(1e-7, 1e-3, ErrorCode::bad_planes), std::tuple(2.0, 1.0, ErrorCode::invalid_argument)}) {
        Slicer slicer;
        SliceResult none;
        CHECK(code_of(slice_tuned(slicer, none, view_of(soup), {}, at_random(least, most, 1))) == code);
    }
}

TEST_CASE("layers by height count towards the memory limit", "[engine][planes][errors]") {
    const shapes::Soup soup = box({0, 0, 0}, {4, 4, 4});
    const SliceOptions options = at_heights(std::vector<double>(10000, 2.0));
    CHECK(failure_of(view_of(soup), options, {.memory_limit_bytes = 10000}).code == ErrorCode::result_too_large);
    CHECK(sliced(soup, options, {.memory_limit_bytes = 90000}).layers.size() == 1);
}

TEST_CASE("layers far thicker than the mesh do not cut it", "[engine][planes]") {
    // A half layer is 2,500 mm or more, and the grid ends at 1,024 mm.
    const shapes::Soup soup = box({-1, -1, -1}, {1, 1, 1});
    for (const double layer_mm : {5'000.0, 10'000.0, 1e6, 1e300}) {
        for (const Datum datum : {Datum::mesh_min, Datum::zero}) {
            SliceOptions options = uniform(layer_mm);
            options.planes.datum = datum;
            double last = 0;
            const auto note = [&](double fraction) noexcept { last = fraction; };
            CHECK(planes_of(sliced(soup, options, {.progress = note})).empty());
            CHECK(last == 1);
        }
    }
}

TEST_CASE("every height has the layer of its plane, whatever their order", "[engine][planes][threads]") {
    std::mt19937 random(13);
    const shapes::Soup soup = shapes::octasphere({5, 5, 5}, 5, 3);
    const std::vector<float> floats = shapes::floats(soup);
    for (int round = 0; round < 60; ++round) {
        const bool as_floats = round % 2 == 0;
        const auto mesh = as_floats ? view_of(floats) : view_of(soup);
        SliceOptions options{.planes = {.side = round % 4 < 2 ? PlaneSide::below : PlaneSide::above},
                             .frame = {.grid_mm = round % 3 == 0 ? 1e-6 : 0x1p-10}};
        std::vector<double> heights = drawn_heights(random, options.frame.grid_mm);
        options.heights_mm = heights;
        const SliceResult result = sliced(mesh, options, {.threads = 1 + round % 3});
        check_layers(result, as_floats ? Number::f32 : Number::f64);
        std::sort(heights.begin(), heights.end());
        options.heights_mm = heights;
        const SliceResult sorted = sliced(mesh, options, {.threads = 3 - round % 3});
        CHECK(sorted.hash() == result.hash());
        CHECK(std::is_sorted(sorted.info.layer_of.begin(), sorted.info.layer_of.end()));
    }
}

}  // namespace
