// Meshes with unevenly distributed work: all in a few layers, all in tall facets, many contours in one layer, and planes
// that all threads work on together.
#include <algorithm>
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

constexpr std::size_t wide = std::size_t{1} << 18;  // fewest segments of a wide plane

/// The side of a prism of `facets` triangles, each with one segment at mid-height. At that plane it looks like a closed
/// mesh.
void add_ring(shapes::Soup& soup, std::size_t facets, double x, double y, double radius) {
    const std::size_t corners = facets / 2;
    const auto corner = [&](std::size_t i, double z) {
        const double angle = 2 * std::acos(-1.0) * static_cast<double>(i % corners) / static_cast<double>(corners);
        return std::array<double, 3>{x + radius * std::cos(angle), y + radius * std::sin(angle), z};
    };
    for (std::size_t i = 0; i < corners; ++i) {
        for (const auto& v :
             {corner(i, 0), corner(i + 1, 0), corner(i + 1, 1), corner(i, 0), corner(i + 1, 1), corner(i, 1)}) {
            soup.insert(soup.end(), v.begin(), v.end());
        }
    }
}

/// Slices at mid-height on 1 and 3 threads and in the assembled form, which never treats a plane as wide.
lamella::SliceResult same_every_way(const shapes::Soup& soup) {
    lamella::SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{0.5}};
    options.control.threads = 1;
    lamella::SliceResult result = sliced(soup, options);
    options.control.threads = 3;
    CHECK(hash_result(sliced(soup, options)) == hash_result(result));
    options.tuning.form = lamella::ContourForm::assembled;
    CHECK(hash_result(sliced(soup, options)) == hash_result(result));
    return result;
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

TEST_CASE("thousands of contours in one layer have the right parents", "[engine][scale]") {
    constexpr int side = 50;
    shapes::Soup mesh = box({-1, -1, 0}, {4 * side, 4 * side, 4});
    for (int i = 0; i < side * side; ++i) {
        const int row = i / side;
        const double x = 4.0 * (i - row * side);
        const double y = 4.0 * row;
        shapes::append(mesh, shapes::flipped(box({x, y, 1}, {x + 3, y + 3, 3})));
        shapes::append(mesh, box({x + 1, y + 1, 1}, {x + 2, y + 2, 3}));
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

TEST_CASE("more unshared edges than the edge map expects become open polylines", "[engine][scale]") {
    constexpr int count = 40'000;
    shapes::Soup soup;
    for (int i = 0; i < count; ++i) {
        const double x = 3 * (i % 200);
        const double y = 3 * (i / 200);
        shapes::append(soup, shapes::triangle({x, y, 0}, {x + 1, y, 0}, {x, y + 1, 2}));
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
    const auto add = [&soup](const shapes::Soup& facet) { shapes::append(soup, facet); };
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

TEST_CASE("a wide plane of one contour gives the same bytes on any number of threads", "[engine][wide][threads]") {
    shapes::Soup soup;
    add_ring(soup, wide + 64, 0, 0, 900);
    const lamella::SliceResult result = same_every_way(soup);
    REQUIRE(result.contours.size() == 1);
    CHECK(result.contours[0].segments == wide + 64);
    CHECK(result.area_mm2(result.layers[0]) == Approx(std::acos(-1.0) * 810000).epsilon(1e-6));
}

TEST_CASE("a wide plane of many small nested contours gives the same bytes on any number of threads",
          "[engine][wide][threads]") {
    shapes::Soup soup;
    std::size_t rings = 0;
    for (int x = 0; soup.size() / 9 < wide; ++x) {
        for (int y = 0; y < 100; ++y) {
            add_ring(soup, 8, 3 * x, 3 * y, 1.4);
            add_ring(soup, 22, 3 * x, 3 * y, 0.5);
            rings += 2;
        }
    }
    const lamella::SliceResult result = same_every_way(soup);
    CHECK(result.contours.size() == rings);
    const auto within = std::count_if(result.contours.begin(), result.contours.end(),
                                      [](const lamella::Contour& c) { return c.parent >= 0; });
    CHECK(static_cast<std::size_t>(within) == rings / 2);
}

// So many that the map of a plane's new edges is larger than caches are, and is fetched ahead.
TEST_CASE("32,768 triangles that enter and pass their middle vertices together give the bytes of the assembled form",
          "[engine][wide]") {
    shapes::Soup soup;
    add_ring(soup, 32'768, 0, 0, 900);
    for (std::size_t z = 2; z < soup.size(); z += 3) {
        const double corner = std::atan2(soup[z - 1], soup[z - 2]) / (2 * std::acos(-1.0)) * 16'384;
        soup[z] = 2 * soup[z] + (std::lround(corner) % 2 != 0 ? 1 : 0);  // every other corner is 1 mm higher
    }
    lamella::SliceOptions options;
    options.plan.spacing = lamella::ExplicitPlanes{{0.5, 1.5, 2.5}};
    options.control.threads = 1;
    const lamella::SliceResult result = sliced(soup, options);
    REQUIRE(result.layers.size() == 3);
    CHECK(result.contours_of(result.layers[1]).size() == 1);
    CHECK(result.summary.segments == 24'576 + 32'768 + 24'576);
    options.tuning.form = lamella::ContourForm::assembled;
    CHECK(hash_result(sliced(soup, options)) == hash_result(result));
}

TEST_CASE("a contour in which no piece of a wide plane begins is found", "[engine][wide]") {
    shapes::Soup inner;
    shapes::Soup outer;
    add_ring(inner, wide / 32, 0, 0, 300);
    add_ring(outer, wide, 0, 0, 900);
    // Pieces begin at every 64th place, and all these places belong to the outer ring.
    shapes::Soup soup;
    std::size_t taken[2] = {0, 0};
    const shapes::Soup* rings[2] = {&inner, &outer};
    for (std::size_t place = 0; taken[0] < inner.size() || taken[1] < outer.size(); ++place) {
        const std::size_t ring = place % 64 == 0 || taken[0] == inner.size() ? 1 : 0;
        const auto from = rings[ring]->begin() + static_cast<std::ptrdiff_t>(taken[ring]);
        soup.insert(soup.end(), from, from + 9);
        taken[ring] += 9;
    }
    const lamella::SliceResult result = same_every_way(soup);
    REQUIRE(result.contours.size() == 2);
    CHECK(result.contours[1].parent == 0);
    CHECK(result.contours[1].segments == wide / 32);
}

TEST_CASE("a wide plane through an open mesh falls back to a band's sweep", "[engine][wide]") {
    shapes::Soup soup;
    add_ring(soup, wide + 64, 0, 0, 900);
    soup.resize(soup.size() - 9);
    const lamella::SliceResult result = same_every_way(soup);
    REQUIRE(result.contours.size() == 1);
    CHECK(result.contours[0].role == lamella::Role::open);
    CHECK(result.contours[0].segments == wide + 63);
}

TEST_CASE("a wide plane through a doubled facet falls back to a band's sweep", "[engine][wide]") {
    shapes::Soup soup;
    add_ring(soup, wide + 64, 0, 0, 900);
    soup.insert(soup.end(), soup.begin(), soup.begin() + 9);
    const lamella::SliceResult result = same_every_way(soup);
    REQUIRE(result.contours.size() == 2);
    CHECK(result.summary.open_contours == 1);
}
