// Meshes with unevenly distributed work: all in a few layers, all in tall facets, many contours in one layer, and planes
// that all threads work on together.
#include <algorithm>
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "engine/counting_memory.hpp"
#include "engine/slicing.hpp"

namespace {

constexpr double mebibyte = 1 << 20;
constexpr lamella::Tuning assembled{.form = lamella::ContourForm::assembled};

/// Upper bound for the memory that slicing may hold besides the input.
double allowance(const lamella::SliceResult& result) {
    const std::size_t arrays = result.layers.size() * sizeof(lamella::Layer) +
                               result.contours.size() * sizeof(lamella::Contour) +
                               result.points.size() * sizeof(lamella::Point);
    return 48 * static_cast<double>(result.info.crossed) + 1.2 * static_cast<double>(arrays) + 64 * mebibyte;
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
    options.heights_mm = {{0.5}};
    lamella::SliceResult result = sliced(soup, options, {.threads = 1});
    CHECK(sliced(soup, options, {.threads = 3}).hash() == result.hash());
    CHECK(sliced(soup, options, {.threads = 3}, assembled).hash() == result.hash());
    return result;
}

}  // namespace

TEST_CASE("a tall prism of 400,000 facets is not copied once per band", "[engine][scale]") {
    constexpr int quarters = 25'000;
    const shapes::Soup prism = shapes::prism(quarters, 50, 100);
    REQUIRE(prism.size() == 9 * std::size_t{16 * quarters - 4});
    std::uint64_t expected = 0;
    for (const std::int64_t band : {0, 1, 3}) {
        CountingMemory memory;
        lamella::Slicer slicer;
        lamella::SliceResult result(&memory);
        value_of(slice_tuned(slicer, result, view_of(prism), uniform(5), {.band_planes = band},
                             {.threads = 2, .memory = &memory}));
        if (band == 1) {
            CHECK(result.info.bands == 10);  // bands of one plane each would have 3.8 million seeds
        }
        expected = band == 0 ? result.hash() : expected;
        CHECK(result.hash() == expected);
        CHECK(static_cast<double>(memory.peak()) < allowance(result));
        REQUIRE(result.layers.size() == 20);
        for (const lamella::LayerView layer : result) {
            REQUIRE(layer.contour_count == 1);
            CHECK(layer.contours[0].segments == 8 * quarters);
            CHECK(layer.area_mm2() == Approx(std::acos(-1.0) * 2500).epsilon(1e-6));
        }
    }
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
    CHECK(result.info.segments == 3 * count);
    CHECK(result.info.open_contours == 2 * count);
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
    options.heights_mm = {{0.5, 1.5, 2.5}};
    const lamella::SliceResult result = sliced(soup, options, {.threads = 1});
    REQUIRE(result.layers.size() == 3);
    CHECK(result.contours_of(result.layers[1]).size() == 1);
    CHECK(result.info.segments == 24'576 + 32'768 + 24'576);
    CHECK(sliced(soup, options, {.threads = 1}, assembled).hash() == result.hash());
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

TEST_CASE("a wide plane through an open mesh, or a doubled facet, falls back to a band's sweep", "[engine][wide]") {
    shapes::Soup ring;
    add_ring(ring, wide + 64, 0, 0, 900);
    const lamella::SliceResult open = same_every_way(shapes::without(ring, wide + 63, 1));
    REQUIRE(open.contours.size() == 1);
    CHECK(open.contours[0].role == lamella::Role::open);
    CHECK(open.contours[0].segments == wide + 63);
    const lamella::SliceResult doubled = same_every_way(shapes::joined({ring, shapes::only(ring, 0, 1)}));
    REQUIRE(doubled.contours.size() == 2);
    CHECK(doubled.info.open_contours == 1);
}
