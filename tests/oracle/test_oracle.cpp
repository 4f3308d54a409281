// Tests the oracle on contours known by hand, and the comparison on results that differ.
#include <algorithm>

#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using lamella::Point;
using lamella::Role;

namespace {

using Points = std::vector<Point>;

const shapes::Soup shells =
    shapes::joined({shapes::box({0, 0, 0}, {8, 8, 8}), shapes::flipped(shapes::box({2, 2, 2}, {6, 6, 6})),
                    shapes::triangle({9, 0, 0}, {12, 0, 0}, {9, 0, 8})});

oracle::Layer layer_of_shells() {
    return oracle::slice_at(oracle::quantise(shells, coarse_unit_mm), 5);
}

}  // namespace

TEST_CASE("the oracle finds an outer, its hole and an open polyline", "[oracle]") {
    const oracle::Layer layer = layer_of_shells();
    REQUIRE(layer.size() == 3);
    CHECK(layer[0].points == Points{{0, 0}, {5, 0}, {16, 0}, {16, 5}, {16, 16}, {11, 16}, {0, 16}, {0, 11}});
    CHECK(layer[0].role == Role::outer);
    CHECK(layer[0].twice_area == 512);
    CHECK(layer[1].points == Points{{4, 4}, {4, 11}, {4, 12}, {11, 12}, {12, 12}, {12, 5}, {12, 4}, {5, 4}});
    CHECK(layer[1].role == Role::hole);
    CHECK(layer[1].parent == 0);
    CHECK(layer[1].orientation == -1);
    CHECK(layer[2].points == Points{{18, 0}, {22, 0}});
    CHECK(layer[2].role == Role::open);
    CHECK(layer[2].segments == 1);
}

TEST_CASE("the oracle rounds ties to even and drops degenerate triangles", "[oracle]") {
    const shapes::Soup soup = shapes::triangle({0.5, 1.5, 2.5}, {-0.5, 3, 4}, {5, 6, 7});
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, coarse_unit_mm);
    REQUIRE(triangles.size() == 1);
    CHECK(triangles[0][0] == lamella::GridVertex{0, 4, 4});
    CHECK(triangles[0][1] == lamella::GridVertex{0, 6, 8});
    CHECK(oracle::quantise(shapes::triangle({0, 0, 0}, {0.4, 0, 0}, {5, 6, 7}), coarse_unit_mm).empty());
}

TEST_CASE("the comparison finds every difference", "[oracle]") {
    const oracle::Layer expected = layer_of_shells();
    const auto differs = [&](auto&& damage) {
        lamella::SliceResult result = sliced(shells, at_heights({3}));
        damage(result);
        return !oracle::difference(result, result.layers[0], expected).empty();
    };
    CHECK_FALSE(differs([](lamella::SliceResult&) {}));
    CHECK(differs([](lamella::SliceResult& r) { r.points[3].x += 1; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].parent = -1; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].role = Role::outer; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].orientation = 1; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].flags = 1; }));
    CHECK(differs([](lamella::SliceResult& r) { ++r.contours[2].segments; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[0].twice_area.low ^= 1; }));
    CHECK(differs([](lamella::SliceResult& r) { --r.layers[0].contour_count; }));
    CHECK(differs([](lamella::SliceResult& r) { std::rotate(&r.points[0], &r.points[1], &r.points[0] + 8); }));
}
