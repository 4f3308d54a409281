// Meshes small enough for all their contours to be known and written down.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "oracle/compare.hpp"

using Lines = std::vector<std::string>;
using shapes::box;
using shapes::flipped;
using shapes::joined;

namespace {

/// The contours at height `mm` on the coarse grid. The oracle must find the same.
Lines cut(const shapes::Soup& soup, double mm) {
    const lamella::SliceResult result = sliced(soup, at_heights({mm}));
    CHECK(oracle::difference(result, oracle::quantise(soup, coarse_unit_mm)).empty());
    return contours_at(result, 0);
}

const shapes::Soup cube = box({0, 0, 0}, {4, 4, 4});
const shapes::Soup large = box({0, 0, 0}, {8, 8, 8});
const shapes::Soup inner = box({2, 2, 2}, {6, 6, 6});

const std::string square = " 0,0 1,0 8,0 8,1 8,8 7,8 0,8 0,7";
const std::string large_square = " 0,0 5,0 16,0 16,5 16,16 11,16 0,16 0,11";
const std::string inner_square = " 4,4 5,4 12,4 12,5 12,12 11,12 4,12 4,11";
const std::string inner_clockwise = " 4,4 4,11 4,12 11,12 12,12 12,5 12,4 5,4";

/// Triangle t of a soup.
shapes::Soup facet(const shapes::Soup& soup, std::size_t t) {
    const auto first = soup.begin() + static_cast<std::ptrdiff_t>(9 * t);
    return {first, first + 9};
}

shapes::Soup without(shapes::Soup soup, std::size_t first, std::size_t count) {
    const auto begin = soup.begin() + static_cast<std::ptrdiff_t>(9 * first);
    soup.erase(begin, begin + static_cast<std::ptrdiff_t>(9 * count));
    return soup;
}

constexpr std::size_t front = 4;  // index of the first triangle of a box's front side

}  // namespace

TEST_CASE("a cube gives one outer contour", "[engine][solids]") {
    CHECK(cut(cube, 1) == Lines{"outer + x8 in -:" + square});
    const lamella::SliceResult result = sliced(cube, at_heights({1, 2, 3, 4}));
    REQUIRE(result.layers.size() == 4);
    for (const lamella::Layer& layer : result.layers) {
        CHECK(result.area_mm2(layer) == 16);
        CHECK(layer.segments == 8);
    }
    CHECK(result.summary.triangles == 12);
    CHECK(result.summary.crossed == 8);
    CHECK(result.summary.segments == 32);
}

TEST_CASE("two cubes that share an edge give two contours", "[engine][solids]") {
    CHECK(cut(joined({cube, box({4, 4, 0}, {8, 8, 4})}), 1) ==
          Lines{"outer + x8 in -:" + square, "outer + x8 in -: 8,8 9,8 16,8 16,9 16,16 15,16 8,16 8,15"});
}

TEST_CASE("two cubes that share a side give two contours", "[engine][solids]") {
    CHECK(cut(joined({cube, box({4, 0, 0}, {8, 4, 4})}), 1) ==
          Lines{"outer + x8 in -:" + square, "outer + x8 in -: 8,0 9,0 16,0 16,1 16,8 15,8 8,8 8,7"});
}

TEST_CASE("a cube that is there twice gives two equal contours", "[engine][solids]") {
    CHECK(cut(joined({cube, cube}), 1) == Lines{"outer + x8 in -:" + square, "outer + x8 in -:" + square});
}

TEST_CASE("a tetrahedron that is there several times gives as many equal contours", "[engine][solids]") {
    const shapes::Soup corner =
        joined({shapes::triangle({0, 0, 0}, {0, 4, 0}, {4, 0, 0}), shapes::triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 4}),
                shapes::triangle({0, 0, 0}, {0, 0, 4}, {0, 4, 0}), shapes::triangle({4, 0, 0}, {0, 4, 0}, {0, 0, 4})});
    const std::string line = "outer + x3 in -: 0,0 7,0 0,7";
    CHECK(cut(corner, 1) == Lines{line});
    CHECK(cut(joined({corner, corner}), 1) == Lines{line, line});
    CHECK(cut(joined({corner, corner, corner}), 1) == Lines{line, line, line});
}

TEST_CASE("a flipped facet does not open its contour", "[engine][solids]") {
    const shapes::Soup patched = joined({without(cube, front, 1), flipped(facet(cube, front))});
    CHECK(cut(patched, 1) == Lines{"outer + x8 in - mixed:" + square});
}

TEST_CASE("a duplicate facet gives an open polyline beside the whole contour", "[engine][solids]") {
    CHECK(cut(joined({cube, facet(cube, front)}), 1) == Lines{"outer + x8 in -:" + square, "open 0 x1 in -: 1,0 8,0"});
}

TEST_CASE("an inverted cube is an outer contour marked as overruled", "[engine][solids]") {
    CHECK(cut(flipped(cube), 1) == Lines{"outer - x8 in - overruled:" + square});
}

TEST_CASE("a cavity is a hole with the solid as parent", "[engine][solids]") {
    CHECK(cut(joined({large, flipped(inner)}), 3) ==
          Lines{"outer + x8 in -:" + large_square, "hole - x8 in 0:" + inner_clockwise});
}

TEST_CASE("roles of an inverted cube with a cavity are decided by parity", "[engine][solids]") {
    CHECK(cut(joined({flipped(large), inner}), 3) ==
          Lines{"outer - x8 in - overruled:" + large_square, "hole + x8 in 0 overruled:" + inner_clockwise});
}

TEST_CASE("a cube in a cube of the same orientation stays an outer contour", "[engine][solids]") {
    CHECK(cut(joined({large, inner}), 3) == Lines{"outer + x8 in -:" + large_square, "outer + x8 in 0:" + inner_square});
}

TEST_CASE("a solid in a cavity is an outer contour with the cavity as parent", "[engine][solids]") {
    const Lines lines = cut(joined({large, flipped(inner), box({3, 3, 2}, {5, 5, 4})}), 3);
    CHECK(lines == Lines{"outer + x8 in -:" + large_square, "hole - x8 in 0:" + inner_clockwise,
                         "outer + x8 in 1: 6,6 7,6 10,6 10,7 10,10 9,10 6,10 6,9"});
}

TEST_CASE("the role of a cavity in a cavity is decided by parity and marked", "[engine][solids]") {
    const Lines lines = cut(joined({large, flipped(inner), flipped(box({3, 3, 2}, {5, 5, 4}))}), 3);
    CHECK(lines == Lines{"outer + x8 in -:" + large_square, "hole - x8 in 0:" + inner_clockwise,
                         "outer - x8 in 1 overruled: 6,6 7,6 10,6 10,7 10,10 9,10 6,10 6,9"});
}

TEST_CASE("overlapping cubes keep their orientation", "[engine][solids]") {
    CHECK(cut(joined({cube, box({2, 2, 0}, {6, 6, 4})}), 1) ==
          Lines{"outer + x8 in -:" + square, "outer + x8 in 0: 4,4 5,4 12,4 12,5 12,12 11,12 4,12 4,11"});
}

TEST_CASE("a hole comes directly after its outer", "[engine][solids]") {
    // A second solid starts between the outer and its hole.
    const shapes::Soup beside = box({1, 9, 0}, {3, 11, 8});
    CHECK(cut(joined({large, beside, flipped(inner)}), 3) ==
          Lines{"outer + x8 in -:" + large_square, "hole - x8 in 0:" + inner_clockwise,
                "outer + x8 in -: 2,18 3,18 6,18 6,19 6,22 5,22 2,22 2,21"});
}

TEST_CASE("a single triangle is an open polyline that starts at its source", "[engine][solids]") {
    CHECK(cut(shapes::triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 4}), 1) == Lines{"open 0 x1 in -: 0,0 7,0"});
    CHECK(cut(shapes::triangle({0, 0, 0}, {0, 0, 4}, {4, 0, 0}), 1) == Lines{"open 0 x1 in -: 7,0 0,0"});
}

TEST_CASE("a box without a side is an open polyline; without a lid it is closed", "[engine][solids]") {
    CHECK(cut(without(cube, front, 2), 1) == Lines{"open 0 x6 in -: 8,0 8,1 8,8 7,8 0,8 0,7 0,0"});
    CHECK(cut(without(cube, 2, 2), 1) == Lines{"outer + x8 in -:" + square});
}

TEST_CASE("a two-sided sheet gives a flat contour", "[engine][solids]") {
    const shapes::Soup sheet = shapes::triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 4});
    CHECK(cut(joined({sheet, flipped(sheet)}), 1) == Lines{"flat 0 x2 in -: 0,0 7,0"});
}

TEST_CASE("a triangle without width gives an open polyline of one point", "[engine][solids]") {
    CHECK(cut(shapes::triangle({1, 1, 0}, {1, 1, 4}, {1, 1, 2}), 1) == Lines{"open 0 x1 in -: 2,2"});
}

TEST_CASE("degenerate triangles are dropped and counted", "[engine][solids]") {
    const shapes::Soup extra =
        joined({shapes::triangle({1, 1, 0}, {1, 1, 0}, {2, 2, 4}), shapes::triangle({1, 1, 0}, {1.2, 1.1, 0.3}, {2, 2, 4}),
                shapes::triangle({3, 3, 3}, {3, 3, 3}, {3, 3, 3})});
    const lamella::SliceResult clean = sliced(cube, at_heights({1, 3}));
    const lamella::SliceResult dirty = sliced(joined({extra, cube}), at_heights({1, 3}));
    CHECK(hash_result(clean) == hash_result(dirty));
    CHECK(dirty.summary.degenerate == 3);
    CHECK(dirty.summary.triangles == 15);
    CHECK(clean.summary.degenerate == 0);
}

TEST_CASE("contours that touch after rounding do not fuse", "[engine][solids]") {
    // The boxes are 0.2 mm apart, less than the grid of 1 mm resolves. Their edges become equal, as if they touched.
    CHECK(cut(joined({cube, box({4.2, 4.2, 0}, {8, 8, 4})}), 1).size() == 2);
    // Tips of two wedges whose crossings round to the same point, on different mesh edges.
    const shapes::Soup left = shapes::octasphere({0, 0, 2}, 3, 1);
    const shapes::Soup right = shapes::octasphere({6, 0, 2}, 3, 1);
    CHECK(cut(joined({left, right}), 2).size() == 2);
}
