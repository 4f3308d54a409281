// Triangles of polygons. Where all of them turn the same way and their boundary is the polygon, they cover it exactly once:
// how often a point is covered is then how often the outline winds around it. That is what is checked, in integers.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

#include "base/numbers.hpp"
#include "io/read/polygon.hpp"

namespace lamella {
namespace {

struct Place {
    std::int64_t x = 0;
    std::int64_t y = 0;
};
using Outline = std::vector<Place>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Int128 turn(const Place& a, const Place& b, const Place& c) {
    return Int128{b.x - a.x} * (c.y - a.y) - Int128{b.y - a.y} * (c.x - a.x);
}

std::vector<std::uint32_t> counted(std::size_t count) {
    std::vector<std::uint32_t> corners(count);
    std::iota(corners.begin(), corners.end(), 0U);
    return corners;
}

Triangles triangles_of(PolygonTriangulator& triangulator, const std::vector<std::uint32_t>& corners,
                       const VertexCoordinates& vertices) {
    Triangles triangles(corners.size() - 2);
    REQUIRE(triangulator.triangulate(corners, vertices, triangles[0].data()) == triangles.size());
    return triangles;
}

/// The outline in the plane of `axis`, as T; the other two axes in such an order that it keeps its orientation.
template <class T>
std::vector<T> standing(const Outline& outline, std::size_t axis, double tilt) {
    std::vector<T> xyz(3 * outline.size());
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const auto x = static_cast<double>(outline[i].x);
        const auto y = static_cast<double>(outline[i].y);
        xyz[3 * i + (axis + 1) % 3] = static_cast<T>(x);
        xyz[3 * i + (axis + 2) % 3] = static_cast<T>(y);
        xyz[3 * i + axis] = static_cast<T>(tilt * x - tilt / 2 * y);
    }
    return xyz;
}

template <class T>
VertexCoordinates coordinates(const std::vector<T>& xyz) {
    return {reinterpret_cast<const std::byte*>(xyz.data()), 3 * sizeof(T), sizeof(T) == 4 ? Number::f32 : Number::f64};
}

/// Each edge of the outline once, and every other one as often as its reverse.
bool has_boundary(const Triangles& triangles, std::size_t corners) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    for (const auto& t : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            ++uses[{t[i], t[(i + 1) % 3]}];
            --uses[{t[(i + 1) % 3], t[i]}];
        }
    }
    for (std::uint32_t i = 0; i < corners; ++i) {
        const auto next = static_cast<std::uint32_t>((i + 1) % corners);
        --uses[{i, next}];
        ++uses[{next, i}];
    }
    return std::all_of(uses.begin(), uses.end(), [](const auto& use) { return use.second == 0; });
}

/// Of a counter-clockwise outline. `flat`: how many of the triangles may have no area.
bool covers(const Triangles& triangles, const Outline& outline, std::size_t flat = 0) {
    std::size_t without_area = 0;
    for (const auto& t : triangles) {
        const Int128 area = turn(outline[t[0]], outline[t[1]], outline[t[2]]);
        if (area < 0) {
            return false;
        }
        without_area += static_cast<std::size_t>(area == 0);
    }
    return without_area <= flat && has_boundary(triangles, outline.size());
}

/// The outline in three planes, upright and tilted, from both sides, as floats and doubles, from several first corners.
void check(Outline outline, std::size_t flat = 0) {
    PolygonTriangulator triangulator;
    const std::vector<std::uint32_t> corners = counted(outline.size());
    for (std::size_t turns = 0; turns < 3; ++turns) {
        std::rotate(outline.begin(), outline.begin() + 1, outline.end());
        for (const std::size_t axis : {0U, 1U, 2U}) {
            for (const double tilt : {0.0, 0.5}) {
                const auto doubles = standing<double>(outline, axis, tilt);
                const Triangles triangles = triangles_of(triangulator, corners, coordinates(doubles));
                CHECK(covers(triangles, outline, flat));
                const auto floats = standing<float>(outline, axis, tilt);
                CHECK(triangles_of(triangulator, corners, coordinates(floats)) == triangles);

                std::vector<std::uint32_t> back = corners;
                std::reverse(back.begin(), back.end());
                Triangles reversed = triangles_of(triangulator, back, coordinates(doubles));
                for (auto& t : reversed) {
                    std::swap(t[0], t[1]);
                }
                CHECK(covers(reversed, outline, flat));
            }
        }
    }
}

Outline ring(std::size_t corners, const std::vector<std::int64_t>& radii) {
    Outline outline;
    for (std::size_t i = 0; i < corners; ++i) {
        const double angle = 2 * 3.14159265358979323846 * static_cast<double>(i) / static_cast<double>(corners);
        const auto radius = static_cast<double>(radii[i % radii.size()]);
        outline.push_back({std::llround(radius * std::cos(angle)), std::llround(radius * std::sin(angle))});
    }
    return outline;
}

/// Teeth upwards from a bar.
Outline comb(std::int64_t teeth, std::int64_t lean) {
    Outline outline{{0, -10}, {4 * teeth, -10}};
    for (std::int64_t t = teeth; t-- > 0;) {
        outline.push_back({4 * t + 3, 0});
        outline.push_back({4 * t + 2 + lean, 1000});
        outline.push_back({4 * t + 1, 0});
    }
    return outline;
}

TEST_CASE("a triangle, a convex quad and a convex polygon are the fan of their first corner", "[polygon]") {
    PolygonTriangulator triangulator;
    const Outline square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    const auto xyz = standing<float>(square, 2, 0);
    CHECK(triangles_of(triangulator, {2, 3, 1}, coordinates(xyz)) == Triangles{{2, 3, 1}});
    CHECK(triangles_of(triangulator, {0, 1, 2, 3}, coordinates(xyz)) == Triangles{{0, 1, 2}, {0, 2, 3}});
    CHECK(triangles_of(triangulator, {3, 2, 1, 0}, coordinates(xyz)) == Triangles{{3, 2, 1}, {3, 1, 0}});
    const auto seven = standing<double>(ring(7, {1000}), 2, 0.5);
    CHECK(triangles_of(triangulator, {3, 4, 5, 6, 0, 1, 2}, coordinates(seven)) ==
          Triangles{{3, 4, 5}, {3, 5, 6}, {3, 6, 0}, {3, 0, 1}, {3, 1, 2}});
    check(ring(100, {1'000'000}));
}

TEST_CASE("corners in the middle of straight edges get no triangle without area", "[polygon]") {
    check({{0, 0}, {1, 0}, {3, 0}, {4, 0}, {4, 1}, {4, 4}, {2, 4}, {0, 4}, {0, 1}});
    check({{0, 0}, {2, 0}, {4, 0}, {2, 4}});
    check({{0, 0}, {2, 0}, {4, 0}, {2, 2}, {1, 1}});
}

TEST_CASE("holes joined to the outline by a bridge stay empty", "[polygon]") {
    check({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}});
    check({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 3}, {3, 3}});
    // Two holes from one corner, and one from the hole before.
    check({{0, 0},
           {40, 0},
           {40, 40},
           {0, 40},
           {0, 0},
           {5, 10},
           {5, 20},
           {9, 20},
           {5, 10},
           {0, 0},
           {10, 5},
           {20, 9},
           {20, 5},
           {10, 5}});
    check({{0, 0},
           {40, 0},
           {40, 40},
           {0, 40},
           {0, 0},
           {5, 5},
           {5, 9},
           {9, 9},
           {20, 20},
           {20, 25},
           {25, 20},
           {20, 20},
           {9, 9},
           {9, 5},
           {5, 5}});
}

int sign(Int128 value) {
    return static_cast<int>(value > 0) - static_cast<int>(value < 0);
}

bool lies_on(const Place& a, const Place& b, const Place& p) {
    return turn(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
           p.y <= std::max(a.y, b.y);
}

bool meet(const Place& a, const Place& b, const Place& c, const Place& d) {
    return (sign(turn(a, b, c)) != sign(turn(a, b, d)) && sign(turn(c, d, a)) != sign(turn(c, d, b))) || lies_on(a, b, c) ||
           lies_on(a, b, d) || lies_on(c, d, a) || lies_on(c, d, b);
}

/// Swaps edges that meet until none do. False: it did not come to an end, or an edge runs back on the one before.
bool untangle(Outline& outline) {
    const std::size_t count = outline.size();
    const auto swap_first = [&] {
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = i + 2; j < count - (i == 0 ? 1 : 0); ++j) {
                if (meet(outline[i], outline[i + 1], outline[j], outline[(j + 1) % count])) {
                    std::reverse(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                 outline.begin() + static_cast<std::ptrdiff_t>(j) + 1);
                    return true;
                }
            }
        }
        return false;
    };
    for (int round = 0; swap_first(); ++round) {
        if (round == 200) {
            return false;
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        const Place& a = outline[i];
        const Place& b = outline[(i + 1) % count];
        const Place& c = outline[(i + 2) % count];
        if (lies_on(a, b, c) || lies_on(b, c, a)) {
            return false;
        }
    }
    return true;
}

TEST_CASE("concave polygons, random on grids so small that corners lie on a line, are covered exactly", "[polygon]") {
    check(ring(41, {1000, 10, 400}));
    check(comb(20, 700));
    std::mt19937 random(7);
    int tried = 0;
    for (int k = 0; k < 600; ++k) {
        const std::uint32_t range = k % 2 == 0 ? 8 : 1000;
        Outline outline(5 + random() % 20);
        for (Place& place : outline) {
            place = {static_cast<std::int64_t>(random() % range), static_cast<std::int64_t>(random() % range)};
        }
        if (!untangle(outline)) {
            continue;
        }
        Int128 area = 0;
        for (std::size_t i = 2; i < outline.size(); ++i) {
            area += turn(outline[0], outline[i - 1], outline[i]);
        }
        if (area < 0) {
            std::reverse(outline.begin(), outline.end());
        }
        ++tried;
        check(outline);
    }
    CHECK(tried > 300);
}

TEST_CASE("orientations are not rounded", "[polygon]") {
    // Units of 2^-53: the first corner goes over a diagonal by steps in which the products of doubles cannot tell the sides.
    constexpr std::int64_t one = std::int64_t{1} << 53;
    PolygonTriangulator triangulator;
    for (std::int64_t x = 0; x < 24; ++x) {
        for (std::int64_t y = 0; y < 24; ++y) {
            const Outline outline{
                {one / 2 + x, one / 2 + y}, {12 * one, 12 * one}, {24 * one, 24 * one}, {0, 24 * one}, {-one, 12 * one}};
            const auto xyz = standing<double>(outline, 2, 0);
            CHECK(covers(triangles_of(triangulator, counted(5), coordinates(xyz)), outline));
        }
    }
}

TEST_CASE("polygons that cross themselves, and such without area, keep their boundary", "[polygon]") {
    PolygonTriangulator triangulator;
    std::mt19937 random(3);
    for (std::size_t count = 4; count < 60; ++count) {
        std::vector<double> xyz(3 * count);
        const std::uint32_t range = count % 3 == 0 ? 2 : 50;
        for (double& value : xyz) {
            value = static_cast<double>(random() % range) * 1e30;
        }
        CHECK(has_boundary(triangles_of(triangulator, counted(count), coordinates(xyz)), count));
    }
    const std::vector<double> one_place(3 * 40, 0.1);
    CHECK(has_boundary(triangles_of(triangulator, counted(40), coordinates(one_place)), 40));
}

/// A quarter of a disc with holes, each reached by a bridge from the centre.
Outline pierced(std::int64_t holes) {
    constexpr std::int64_t radius = 1'000'000'000;
    Outline outline{{0, 0}, {radius, 0}, {radius, radius}, {0, radius}};
    for (std::int64_t hole = holes; hole-- > 0;) {
        const std::int64_t y = (hole * 2 + 1) * (radius / 2 / holes);
        constexpr std::int64_t x = radius / 2;
        outline.insert(outline.end(), {{0, 0}, {x, y}, {x + 9, y + 99'000}, {x + 99'000, y + 9}, {x, y}});
    }
    return outline;
}

TEST_CASE("polygons of ten thousand corners are covered exactly, hostile ones refused", "[polygon]") {
    PolygonTriangulator triangulator;
    std::mt19937 random(5);
    std::vector<std::int64_t> radii(10'000);
    for (std::int64_t& radius : radii) {
        radius = 100'000'000 + static_cast<std::int64_t>(random() % 100'000'000);
    }
    for (const Outline& outline : {ring(radii.size(), radii), comb(3000, 9000), pierced(2000)}) {
        const auto xyz = standing<double>(outline, 2, 0);
        CHECK(covers(triangles_of(triangulator, counted(outline.size()), coordinates(xyz)), outline));
    }
    const std::vector<double> triangle{0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<std::uint32_t> corners(50'000);
    for (std::uint32_t& corner : corners) {
        corner = static_cast<std::uint32_t>(random() % 3);
    }
    std::vector<std::uint32_t> out(3 * corners.size());
    CHECK(triangulator.triangulate(corners, coordinates(triangle), out.data()) == 0);
}

}  // namespace
}  // namespace lamella
