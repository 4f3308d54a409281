// Contours from the segments that a caller passes, with the caller's keys and ranks.
#include <catch2/catch.hpp>

#include "engine/slicing.hpp"
#include "lamella/layers.hpp"

using lamella::EndKey;
using lamella::Point;
using lamella::Role;
using lamella::Segment;
using lamella::SliceResult;

namespace {

EndKey key(std::uint64_t a) {
    return {a, 0, 0};
}

SliceResult assembled(const std::vector<Segment>& segments) {
    SliceResult layer = value_of(assemble(segments));
    std::uint64_t sum = 0;
    for (const lamella::Contour& contour : layer.contours) {
        sum += contour.segments;
    }
    REQUIRE(sum == segments.size());
    return layer;
}

std::vector<Point> points_of(const SliceResult& layer, std::size_t c) {
    const auto points = layer.points_of(layer.contours[c]);
    return {points.begin(), points.end()};
}

/// A closed polygon, its corners keyed from `first` on.
std::vector<Segment> polygon(const std::vector<Point>& corners, std::uint64_t first) {
    std::vector<Segment> segments;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const std::size_t next = (i + 1) % corners.size();
        segments.push_back({key(first + i), key(first + next), corners[i], corners[next], 0, 0});
    }
    return segments;
}

std::vector<Segment> operator+(std::vector<Segment> a, const std::vector<Segment>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

using Points = std::vector<Point>;

}  // namespace

TEST_CASE("the parent of a hole in a square is the square", "[assemble]") {
    const SliceResult layer =
        assembled(polygon({{2, 2}, {2, 4}, {4, 4}, {4, 2}}, 1) + polygon({{9, 0}, {9, 9}, {0, 9}, {0, 0}}, 11));
    REQUIRE(layer.contours.size() == 2);
    CHECK(layer.contours[1].role == Role::hole);
    CHECK(layer.contours[1].parent == 0);
    CHECK(points_of(layer, 1) == Points{{2, 2}, {2, 4}, {4, 4}, {4, 2}});
    const double square_unit = lamella::default_grid_mm * lamella::default_grid_mm;
    CHECK(layer[0].area_mm2() == (81 - 4) * square_unit);
    CHECK(layer[0].area_mm2(layer.contours[1]) == -4 * square_unit);
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

TEST_CASE("the key of an edge does not depend on the order of its vertices", "[assemble]") {
    const lamella::GridVertex u{2, -4, 6};
    const lamella::GridVertex v{-2, 8, 10};
    CHECK(EndKey::of_edge(u, v) == EndKey::of_edge(v, u));
    CHECK(EndKey::of_edge(u, v) != EndKey::of_edge(u, {-2, 8, 12}));
    // Keys compare by lower ends first, then by upper ends.
    CHECK(EndKey::of_edge({-4, 0, 0}, v) < EndKey::of_edge({-2, -6, -8}, v));
    CHECK(EndKey::of_edge(u, v) < EndKey::of_edge(u, {0, -8, 10}));
}
