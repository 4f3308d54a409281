// Meshes small enough for all their contours to be known and written down; and contours from the segments that a caller
// passes, with the caller's keys and ranks.
#include <tuple>

#include "engine/slicing.hpp"
#include "lamella/layers.hpp"
#include "oracle/compare.hpp"

using namespace lamella;
using namespace shapes;

using Lines = std::vector<std::string>;

namespace {

/// The contours at height `mm` on the coarse grid. The oracle must find the same.
Lines cut(const Soup& soup, double mm) {
    const SliceResult result = sliced(soup, at_heights({mm}));
    CHECK(oracle::difference(result, oracle::quantise(soup, coarse_unit_mm)).empty());
    return contours_at(result, 0);
}

const Soup cube = box({0, 0, 0}, {4, 4, 4});
const Soup large = box({0, 0, 0}, {8, 8, 8});
const Soup inner = box({2, 2, 2}, {6, 6, 6});

const std::string square = " 0,0 1,0 8,0 8,1 8,8 7,8 0,8 0,7";
const std::string large_square = " 0,0 5,0 16,0 16,5 16,16 11,16 0,16 0,11";
const std::string inner_square = " 4,4 5,4 12,4 12,5 12,12 11,12 4,12 4,11";
const std::string inner_clockwise = " 4,4 4,11 4,12 11,12 12,12 12,5 12,4 5,4";

constexpr std::size_t front = 4;  // index of the first triangle of a box's front side

TEST_CASE("the contours of small meshes are known", "[engine][solids]") {
    const Soup corner = joined({triangle({0, 0, 0}, {0, 4, 0}, {4, 0, 0}), triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 4}),
                                triangle({0, 0, 0}, {0, 0, 4}, {0, 4, 0}), triangle({4, 0, 0}, {0, 4, 0}, {0, 0, 4})});
    const Soup sheet = triangle({0, 0, 0}, {4, 0, 0}, {0, 0, 4});
    const std::string outer = "outer + x8 in -:";
    const std::string once = "outer + x3 in -: 0,0 7,0 0,7";
    const std::string islet = " 6,6 7,6 10,6 10,7 10,10 9,10 6,10 6,9";
    const std::tuple<const char*, Soup, double, Lines> cases[] = {
        {"a cube gives one outer contour", cube, 1, {outer + square}},
        {"two cubes share an edge",
         joined({cube, box({4, 4, 0}, {8, 8, 4})}),
         1,
         {outer + square, outer + " 8,8 9,8 16,8 16,9 16,16 15,16 8,16 8,15"}},
        {"a tetrahedron is there three times", joined({corner, corner, corner}), 1, {once, once, once}},
        {"a flipped facet does not open its contour",
         joined({without(cube, front, 1), flipped(only(cube, front, 1))}),
         1,
         {"outer + x8 in - mixed:" + square}},
        {"a duplicate facet is an open polyline beside the whole contour",
         joined({cube, only(cube, front, 1)}),
         1,
         {outer + square, "open 0 x1 in -: 1,0 8,0"}},
        {"an inverted cube is overruled", flipped(cube), 1, {"outer - x8 in - overruled:" + square}},
        {"a cavity is a hole in the solid",
         joined({large, flipped(inner)}),
         3,
         {outer + large_square, "hole - x8 in 0:" + inner_clockwise}},
        {"roles of an inverted cube with a cavity are decided by parity",
         joined({flipped(large), inner}),
         3,
         {"outer - x8 in - overruled:" + large_square, "hole + x8 in 0 overruled:" + inner_clockwise}},
        {"a cube in a cube of the same orientation stays an outer",
         joined({large, inner}),
         3,
         {outer + large_square, "outer + x8 in 0:" + inner_square}},
        {"a solid in a cavity has the cavity as parent",
         joined({large, flipped(inner), box({3, 3, 2}, {5, 5, 4})}),
         3,
         {outer + large_square, "hole - x8 in 0:" + inner_clockwise, "outer + x8 in 1:" + islet}},
        {"a cavity in a cavity is decided by parity and marked",
         joined({large, flipped(inner), flipped(box({3, 3, 2}, {5, 5, 4}))}),
         3,
         {outer + large_square, "hole - x8 in 0:" + inner_clockwise, "outer - x8 in 1 overruled:" + islet}},
        // The second solid starts between the outer and its hole.
        {"a hole comes directly after its outer",
         joined({large, box({1, 9, 0}, {3, 11, 8}), flipped(inner)}),
         3,
         {outer + large_square, "hole - x8 in 0:" + inner_clockwise, outer + " 2,18 3,18 6,18 6,19 6,22 5,22 2,22 2,21"}},
        {"a triangle is an open polyline from its source", sheet, 1, {"open 0 x1 in -: 0,0 7,0"}},
        {"a box without a side is an open polyline",
         without(cube, front, 2),
         1,
         {"open 0 x6 in -: 8,0 8,1 8,8 7,8 0,8 0,7 0,0"}},
        {"a box without a lid is closed", without(cube, 2, 2), 1, {outer + square}},
        {"a two-sided sheet is a flat contour", joined({sheet, flipped(sheet)}), 1, {"flat 0 x2 in -: 0,0 7,0"}},
        {"a triangle without width is one point", triangle({1, 1, 0}, {1, 1, 4}, {1, 1, 2}), 1, {"open 0 x1 in -: 2,2"}}};
    for (const auto& [name, soup, height_mm, expected] : cases) {
        INFO(name);
        CHECK(cut(soup, height_mm) == expected);
    }
}

EndKey key(std::uint64_t a) {
    return {a, 0, 0};
}

SliceResult assembled(const std::vector<Segment>& segments) {
    SliceResult layer = value_of(assemble(segments));
    std::uint64_t sum = 0;
    for (const Contour& contour : layer.contours) {
        sum += contour.segments;
    }
    REQUIRE(sum == segments.size());
    return layer;
}

TEST_CASE("ranks decide which ends meet at a shared key", "[assemble]") {
    // Two squares meet at (4, 4). Counter-clockwise from the east: a source, a target from the north, a source to the
    // west, a target from the south.
    const EndKey shared = key(99);
    const auto squares = [&](std::uint32_t east_out, std::uint32_t north_in, std::uint32_t west_out,
                             std::uint32_t south_in) {
        return std::vector<Segment>{
            {key(1), key(2), {0, 0}, {4, 0}, 0, 0},        {key(2), shared, {4, 0}, {4, 4}, 0, south_in},
            {shared, key(3), {4, 4}, {0, 4}, west_out, 0}, {key(3), key(1), {0, 4}, {0, 0}, 0, 0},
            {shared, key(4), {4, 4}, {8, 4}, east_out, 0}, {key(4), key(5), {8, 4}, {8, 8}, 0, 0},
            {key(5), key(6), {8, 8}, {4, 8}, 0, 0},        {key(6), shared, {4, 8}, {4, 4}, 0, north_in},
        };
    };
    // Ranks by geometry: each target is paired with the next source clockwise, so each square closes by itself.
    CHECK(assembled(squares(0, 1, 2, 3)).contours.size() == 2);
    // Other ranks give other pairs: a single contour through both squares.
    CHECK(assembled(squares(0, 3, 2, 1)).contours.size() == 1);
    // Rotating all ranks changes nothing.
    CHECK(assembled(squares(2, 3, 0, 1)).contours.size() == 2);
    // At equal ranks, targets come before sources.
    CHECK(assembled(squares(0, 0, 1, 1)).contours.size() == 1);
    CHECK(assembled(squares(0, 1, 1, 0)).contours.size() == 2);
}

TEST_CASE("assemble terminates and uses each segment once for any input", "[assemble]") {
    // A segment from a key to itself; several equal segments; a star of sources without targets.
    std::vector<Segment> segments = {{key(1), key(1), {0, 0}, {0, 0}, 0, 0}, {key(1), key(1), {0, 0}, {3, 0}, 0, 1}};
    for (std::uint32_t i = 0; i < 9; ++i) {
        segments.push_back({key(2), key(3), {0, 0}, {1, 1}, i, i});
        segments.push_back({key(4), key(10 + i), {5, 5}, {5, static_cast<std::int32_t>(i)}, i, 0});
    }
    CHECK_FALSE(assembled(segments).contours.empty());
}

}  // namespace
