// Planes that all threads work on together must give the same bytes as a band's sweep, for contours of any length.
#include <algorithm>
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"

namespace {

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
