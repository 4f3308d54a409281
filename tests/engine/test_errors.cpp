// What the engine refuses.
#include <cmath>
#include <limits>

#include <unistd.h>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"

using lamella::ErrorCode;

TEST_CASE("unusable coordinates are an error that names their triangle", "[engine][errors]") {
    const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                                -std::numeric_limits<double>::infinity(), 3e38, -3e38, 1.1e9, 1e300);
    const std::size_t at = GENERATE(0U, 31U, 9U * 12U - 1U);
    shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 4});
    soup[at] = bad;
    const lamella::Error error = failure_of(view_of(soup), uniform(0.1));
    CHECK(error.code == ErrorCode::bad_coordinate);
    CHECK(error.triangle == static_cast<std::int64_t>(at / 9));
    CHECK_THAT(error.message, Catch::Contains(std::to_string(at / 9)));
    const std::vector<float> floats = shapes::floats(soup);
    if (std::abs(bad) < 1e39 || !std::isfinite(bad)) {
        CHECK(failure_of(lamella::MeshView::soup(std::span<const float>(floats)), uniform(0.1)).triangle == error.triangle);
    }
}

TEST_CASE("a grid too small for the mesh is an error", "[engine][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 2000});
    CHECK(failure_of(view_of(soup), uniform(1, 1e-6)).code == ErrorCode::bad_coordinate);
    CHECK(failure_of(view_of(soup), uniform(1, -0.5)).code == ErrorCode::invalid_argument);
    CHECK(failure_of(view_of(soup), uniform(1, std::nan(""))).code == ErrorCode::invalid_argument);
    const lamella::SliceResult result = sliced(soup, uniform(1));
    CHECK(result.unit_mm == 2 * lamella::default_unit_mm);
    CHECK(sliced(shapes::box({0, 0, 0}, {4, 4, 4}), uniform(1)).unit_mm == lamella::default_unit_mm);
    CHECK(sliced(shapes::box({0, 0, 0}, {9e8, 4, 4}), uniform(3000)).layers.empty());
}

TEST_CASE("an index out of range is an error", "[engine][errors]") {
    shapes::Indexed mesh = shapes::indexed(shapes::box({0, 0, 0}, {4, 4, 4}));
    mesh.indices[20] = static_cast<std::uint32_t>(mesh.xyz.size() / 3);
    const lamella::Error error = failure_of(mesh.view(), uniform(0.1));
    CHECK(error.code == ErrorCode::invalid_argument);
    CHECK(error.triangle == 6);
}

TEST_CASE("results known to be too large are refused before they are allocated", "[engine][errors]") {
    const shapes::Soup soup = shapes::box({0, 0, 0}, {4, 4, 100});
    CountingMemory memory;
    lamella::SliceOptions options = uniform(0.00001);
    options.control.memory = &memory;
    options.memory_limit_bytes = std::uint64_t{1} << 28;
    CHECK(failure_of(view_of(soup), options).code == ErrorCode::result_too_large);
    CHECK(memory.peak() < std::size_t{1} << 26);
    CHECK(memory.held() == 0);
    // The layers fit in the limit, but their points do not.
    options.plan.spacing = lamella::UniformLayers{0.001};
    options.memory_limit_bytes = 11'000'000;
    CHECK(failure_of(view_of(soup), options).code == ErrorCode::result_too_large);
    // Layers and points fit, but not one contour in each layer too.
    const std::uint64_t layers = 100'000;
    const std::uint64_t bytes = layers * (sizeof(lamella::Layer) + 8 * sizeof(lamella::Point) + sizeof(lamella::Contour));
    options.memory_limit_bytes = bytes - 1;
    CHECK(failure_of(view_of(soup), options).code == ErrorCode::result_too_large);
    options.memory_limit_bytes = bytes;
    CHECK(sliced(soup, options).contours.size() == layers);
}

TEST_CASE("the default limit is half of physical memory", "[engine][errors]") {
    constexpr double height_mm = 240;
    constexpr double layer_height_mm = 2.5e-7;
    constexpr double layers_bytes = height_mm / layer_height_mm * sizeof(lamella::Layer);
    const double limit_bytes =
        0.5 * static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
    if (limit_bytes > layers_bytes) {
        WARN("not tested: this machine has memory for the most layers that a grid holds");
        return;
    }
    const shapes::Soup soup = shapes::box({0, 0, -height_mm / 2}, {4, 4, height_mm / 2});
    const lamella::Error error = failure_of(view_of(soup), uniform(layer_height_mm, 0x1p-23));
    CHECK(error.code == ErrorCode::result_too_large);
    CHECK_THAT(error.message, Catch::Contains(std::to_string(static_cast<std::uint64_t>(limit_bytes))));
}

TEST_CASE("a workspace and a result can be reused, even after errors", "[engine][errors]") {
    const shapes::Soup small = shapes::octasphere({0, 0, 0}, 3, 2);
    const shapes::Soup large = shapes::octasphere({0, 0, 0}, 10, 5);
    shapes::Soup broken = large;
    broken[100] = std::nan("");
    const lamella::SliceOptions options = uniform(0.1);
    lamella::Workspace workspace;
    lamella::SliceResult result;
    for (int turn = 0; turn < 2; ++turn) {
        for (const shapes::Soup* soup : {&large, &small}) {
            REQUIRE(slice(view_of(*soup), options, workspace, result).ok());
            CHECK(validate(result).ok());
            CHECK(hash_result(result) == hash_result(sliced(*soup, options)));
            CHECK_FALSE(slice(view_of(broken), options, workspace, result).ok());
        }
    }
}
