// Meshes with unevenly distributed work: all in a few layers, all in tall facets, or many contours in one layer.
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using shapes::box;

namespace {

constexpr double mebibyte = 1 << 20;

/// Upper bound for the memory that slicing may hold besides the input.
double allowance(const lamella::SliceResult& result) {
    const std::size_t arrays = result.layers.size() * sizeof(lamella::Layer) +
                               result.contours.size() * sizeof(lamella::Contour) +
                               result.points.size() * sizeof(lamella::Point);
    return 48 * static_cast<double>(result.summary.crossed) + 1.2 * static_cast<double>(arrays) + 64 * mebibyte;
}

}  // namespace

TEST_CASE("a tall prism of 400,000 facets is not copied once per band", "[engine][scale]") {
    constexpr int quarters = 25'000;
    const shapes::Soup prism = shapes::prism(quarters, 50, 100);
    REQUIRE(prism.size() == 9 * std::size_t{16 * quarters - 4});
    std::uint64_t expected = 0;
    for (const int band : {0, 1, 3}) {
        CountingMemory memory;
        lamella::SliceOptions options = uniform(5);
        options.control.memory = &memory;
        options.control.threads = 2;
        options.tuning.band_planes = band;
        const lamella::SliceResult result = value_of(slice(view_of(prism), options));
        if (band == 1) {
            CHECK(result.summary.bands == 10);  // bands of one plane each would have 3.8 million seeds
        }
        expected = band == 0 ? hash_result(result) : expected;
        CHECK(hash_result(result) == expected);
        CHECK(static_cast<double>(memory.peak()) < allowance(result));
        REQUIRE(result.layers.size() == 20);
        for (const lamella::Layer& layer : result.layers) {
            REQUIRE(layer.contour_count == 1);
            CHECK(result.contours_of(layer)[0].segments == 8 * quarters);
            CHECK(result.area_mm2(layer) == Approx(std::acos(-1.0) * 2500).epsilon(1e-6));
        }
    }
}

TEST_CASE("a wide base under a thin spire agrees with the oracle on any number of threads", "[engine][scale][threads]") {
    const shapes::Soup base = shapes::scaled(shapes::octasphere({0, 0, 0}, 10, 6), {5, 5, 0.02});
    const shapes::Soup spire = box({-0.1, -0.1, 0.1}, {0.1, 0.1, 60});
    const shapes::Soup mesh = shapes::joined({base, spire});
    lamella::SliceOptions options = uniform(0.05);
    options.control.threads = 1;
    const lamella::SliceResult result = sliced(mesh, options);
    REQUIRE(result.layers.size() == 1204);
    for (std::size_t l = 8; l < result.layers.size(); ++l) {
        REQUIRE(contours_at(result, l).size() == 1);
        REQUIRE(result.area_mm2(result.layers[l]) == Approx(0.04).epsilon(1e-4));
    }
    CHECK(result.layers[4].segments > 400);
    const std::vector<oracle::Triangle> triangles = oracle::quantise(mesh, result.unit_mm);
    for (const std::size_t l : {0U, 3U, 4U, 7U, 8U, 1203U}) {
        const lamella::Layer& layer = result.layers[l];
        CHECK_THAT(oracle::difference(result, layer, oracle::slice_at(triangles, layer.plane.z())), Catch::Equals(""));
    }
    for (const int threads : {2, 3, 8}) {
        options.control.threads = threads;
        CHECK(hash_result(sliced(mesh, options)) == hash_result(result));
    }
}

TEST_CASE("one plane through 160,000 facets gives one contour on any number of threads", "[engine][scale][threads]") {
    const shapes::Soup prism = shapes::prism(20'000, 50, 1);
    lamella::SliceOptions options = uniform(1);
    options.control.threads = 1;
    const lamella::SliceResult result = sliced(prism, options);
    REQUIRE(result.layers.size() == 1);
    CHECK(result.layers[0].segments == 160'000);
    CHECK(result.contours.size() == 1);
    for (const int threads : {2, 5}) {
        options.control.threads = threads;
        CHECK(hash_result(sliced(prism, options)) == hash_result(result));
    }
}

TEST_CASE("thousands of contours in one layer have the right parents", "[engine][scale]") {
    constexpr int side = 50;
    shapes::Soup mesh = box({-1, -1, 0}, {4 * side, 4 * side, 4});
    for (int i = 0; i < side * side; ++i) {
        const int row = i / side;
        const double x = 4.0 * (i - row * side);
        const double y = 4.0 * row;
        const shapes::Soup cavity = shapes::flipped(box({x, y, 1}, {x + 3, y + 3, 3}));
        const shapes::Soup island = box({x + 1, y + 1, 1}, {x + 2, y + 2, 3});
        mesh.insert(mesh.end(), cavity.begin(), cavity.end());
        mesh.insert(mesh.end(), island.begin(), island.end());
    }
    const lamella::SliceResult result = sliced(mesh, at_heights({2}));
    REQUIRE(result.contours.size() == 1 + 2 * side * side);
    CHECK(result.summary.holes == side * side);
    CHECK(result.area_mm2(result.layers[0]) == (4.0 * side + 1) * (4.0 * side + 1) - 8.0 * side * side);
    for (std::size_t c = 1; c < result.contours.size(); ++c) {
        const lamella::Contour& contour = result.contours[c];
        if (contour.role == lamella::Role::hole) {
            REQUIRE(contour.parent == 0);
        } else {
            REQUIRE(result.contours[static_cast<std::size_t>(contour.parent)].role == lamella::Role::hole);
        }
    }
}

TEST_CASE("areas times layer height are the volume", "[engine][scale]") {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 5);
    double volume = 0;
    for (std::size_t i = 0; i < ball.size(); i += 9) {
        const double* t = &ball[i];
        volume +=
            (t[0] * (t[4] * t[8] - t[5] * t[7]) + t[1] * (t[5] * t[6] - t[3] * t[8]) + t[2] * (t[3] * t[7] - t[4] * t[6])) /
            6;
    }
    const lamella::SliceResult result = sliced(ball, uniform(0.02));
    double sum = 0;
    for (const lamella::Layer& layer : result.layers) {
        sum += result.area_mm2(layer) * (layer.top_mm - layer.bottom_mm);
    }
    CHECK(sum == Approx(volume).epsilon(1e-5));
}

TEST_CASE("more unshared edges than the edge map expects become open polylines", "[engine][scale]") {
    constexpr int count = 40'000;
    shapes::Soup soup;
    for (int i = 0; i < count; ++i) {
        const double x = 3 * (i % 200);
        const double y = 3 * (i / 200);
        const shapes::Soup facet = shapes::triangle({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 2});
        soup.insert(soup.end(), facet.begin(), facet.end());
    }
    lamella::SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{1}};
    const lamella::SliceResult result = sliced(soup, options);
    CHECK(result.summary.open_contours == count);
    CHECK(result.points.size() == 2 * std::size_t{count});
    options.tuning.form = lamella::ContourForm::assembled;
    options.control.threads = 1;
    CHECK(hash_result(sliced(soup, options)) == hash_result(result));
}

TEST_CASE("an edge map that grows keeps its entries", "[engine][scale]") {
    // The number of edges exceeds half the ends. First come single facets, then pairs that share their short edge: the
    // first faces of all pairs, then the second. The map grows between the first and the second faces.
    constexpr int count = 20'000;
    const auto place = [](int i) { return std::array<double, 2>{4.0 * (i % 200), 4.0 * (i / 200)}; };
    shapes::Soup soup;
    const auto add = [&soup](const shapes::Soup& facet) { soup.insert(soup.end(), facet.begin(), facet.end()); };
    for (int i = 0; i < count; ++i) {
        const auto [x, y] = place(i);
        add(shapes::triangle({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 2}));
    }
    for (int i = count; i < 2 * count; ++i) {
        const auto [x, y] = place(i);
        add(shapes::triangle({x, y, 0}, {x + 1, y, 2}, {x, y + 1, 4}));
    }
    for (int i = count; i < 2 * count; ++i) {
        const auto [x, y] = place(i);
        add(shapes::triangle({x + 1, y, 2}, {x, y, 0}, {x + 2, y + 2, 3}));
    }
    const lamella::SliceResult result = sliced(soup, at_heights({1}));
    CHECK(result.summary.segments == 3 * count);
    CHECK(result.summary.open_contours == 2 * count);
}
