// Triangles of polygons. Where all of them turn the same way and their boundary is the polygon, they cover it exactly once:
// how often a point is covered is then how often the outline winds around it. That is what is checked, in integers.
#include <cstdint>
#include <map>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

#include "engine/polygons.hpp"
#include "io/read/polygon.hpp"
#include "rings.hpp"

namespace lamella {
namespace {

using Outline = std::vector<Point>;
using Fan = std::vector<std::array<std::uint32_t, 3>>;

std::vector<std::uint32_t> counted(std::size_t count) {
    std::vector<std::uint32_t> corners(count);
    std::iota(corners.begin(), corners.end(), 0U);
    return corners;
}

template <class T>
Fan cut(const std::vector<std::uint32_t>& corners, const std::vector<T>& xyz) {
    static PolygonTriangulator triangulator;
    const VertexCoordinates vertices{reinterpret_cast<const std::byte*>(xyz.data()), 3 * sizeof(T),
                                     sizeof(T) == 4 ? Number::f32 : Number::f64};
    Fan triangles(corners.size() - 2);
    REQUIRE(triangulator.triangulate(corners, vertices, triangles[0].data()) == triangles.size());
    return triangles;
}

/// The outline in the plane of `axis`, as T; the other two axes in such an order that it keeps its orientation.
template <class T, class Place>
std::vector<T> standing(const std::vector<Place>& outline, std::size_t axis, double tilt) {
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

/// Each edge of the outline once, and every other one as often as its reverse.
bool has_boundary(const Fan& triangles, std::size_t corners) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    const auto use = [&](std::uint32_t from, std::uint32_t to, int times) {
        uses[{from, to}] += times;
        uses[{to, from}] -= times;
    };
    for (const auto& [a, b, c] : triangles) {
        use(a, b, 1);
        use(b, c, 1);
        use(c, a, 1);
    }
    for (std::uint32_t i = 0; i < corners; ++i) {
        use(i, static_cast<std::uint32_t>((i + 1) % corners), -1);
    }
    return std::all_of(uses.begin(), uses.end(), [](const auto& used) { return used.second == 0; });
}

/// A counter-clockwise outline, by triangles that all have an area.
template <class Place>
bool covers(const Fan& triangles, const std::vector<Place>& outline) {
    const auto turns_left = [&](const auto& t) {
        const auto& [a, b, c] = std::array{outline[t[0]], outline[t[1]], outline[t[2]]};
        using rings::Int128;
        return (Int128{b.x} - a.x) * (Int128{c.y} - a.y) > (Int128{b.y} - a.y) * (Int128{c.x} - a.x);
    };
    return std::all_of(triangles.begin(), triangles.end(), turns_left) && has_boundary(triangles, outline.size());
}

/// The outline in three planes, upright and tilted, from both sides, as floats and doubles, from several first corners.
void check(Outline outline) {
    const std::vector<std::uint32_t> corners = counted(outline.size());
    const std::vector<std::uint32_t> back(corners.rbegin(), corners.rend());
    for (std::size_t way = 0; way < 18; ++way) {
        std::rotate(outline.begin(), outline.begin() + (way % 6 == 0 ? 1 : 0), outline.end());
        const double tilt = way % 2 == 0 ? 0 : 0.5;
        const auto doubles = standing<double>(outline, way / 2 % 3, tilt);
        const Fan triangles = cut(corners, doubles);
        CHECK(covers(triangles, outline));
        CHECK(cut(corners, standing<float>(outline, way / 2 % 3, tilt)) == triangles);
        Fan reversed = cut(back, doubles);
        for (auto& t : reversed) {
            std::swap(t[0], t[1]);
        }
        CHECK(covers(reversed, outline));
    }
}

Outline ring(std::size_t corners, const std::vector<int>& radii) {
    Outline outline;
    for (std::size_t i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
        outline.push_back(polygons::at_angle({0, 0}, radii[i % radii.size()], angle));
    }
    return outline;
}

/// Teeth upwards from a bar.
Outline comb(int teeth, int lean) {
    Outline outline{{0, -10}, {4 * teeth, -10}};
    for (int t = teeth; t-- > 0;) {
        outline.insert(outline.end(), {{4 * t + 3, 0}, {4 * t + 2 + lean, 1000}, {4 * t + 1, 0}});
    }
    return outline;
}

/// A quarter of a disc with holes, each reached by a bridge from the centre.
Outline pierced(int holes) {
    constexpr int radius = 1'000'000'000;
    constexpr int x = radius / 2;
    Outline outline{{0, 0}, {radius, 0}, {radius, radius}, {0, radius}};
    for (int hole = holes; hole-- > 0;) {
        const int y = (hole * 2 + 1) * (radius / 2 / holes);
        outline.insert(outline.end(), {{0, 0}, {x, y}, {x + 9, y + 99'000}, {x + 99'000, y + 9}, {x, y}});
    }
    return outline;
}

/// Swaps edges that meet until none do. False: it did not come to an end, or an edge runs back on the one before.
bool untangle(Outline& outline) {
    const std::size_t count = outline.size();
    const auto at = [&](std::size_t i) { return outline[i % count]; };
    const auto swap_first = [&] {
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = i + 2; j < count - (i == 0 ? 1 : 0); ++j) {
                if (rings::meet(at(i), at(i + 1), at(j), at(j + 1))) {
                    std::reverse(outline.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                 outline.begin() + static_cast<std::ptrdiff_t>(j) + 1);
                    return true;
                }
            }
        }
        return false;
    };
    int rounds = 0;
    while (rounds < 200 && swap_first()) {
        ++rounds;
    }
    bool simple = rounds < 200;
    for (std::size_t i = 0; i < count; ++i) {
        simple = simple && !rings::lies_on(at(i), at(i + 1), at(i + 2)) && !rings::lies_on(at(i + 1), at(i + 2), at(i));
    }
    return simple;
}

TEST_CASE("a triangle, a convex quad and a convex polygon are the fan of their first corner", "[polygon]") {
    const auto xyz = standing<float>(Outline{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, 2, 0);
    CHECK(cut({2, 3, 1}, xyz) == Fan{{2, 3, 1}});
    CHECK(cut({0, 1, 2, 3}, xyz) == Fan{{0, 1, 2}, {0, 2, 3}});
    CHECK(cut({3, 2, 1, 0}, xyz) == Fan{{3, 2, 1}, {3, 1, 0}});
    const auto seven = standing<double>(ring(7, {1000}), 2, 0.5);
    CHECK(cut({3, 4, 5, 6, 0, 1, 2}, seven) == Fan{{3, 4, 5}, {3, 5, 6}, {3, 6, 0}, {3, 0, 1}, {3, 1, 2}});
}

TEST_CASE("polygons that are convex, concave, straight at corners, or have holes joined by bridges are covered",
          "[polygon]") {
    check(ring(100, {1'000'000}));
    check(ring(41, {1000, 10, 400}));
    check(comb(20, 700));
    check({{0, 0}, {1, 0}, {3, 0}, {4, 0}, {4, 1}, {4, 4}, {2, 4}, {0, 4}, {0, 1}});
    check({{0, 0}, {2, 0}, {4, 0}, {2, 4}});
    check({{0, 0}, {2, 0}, {4, 0}, {2, 2}, {1, 1}});
    check({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}});
    check({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 3}, {3, 3}});
    // A hole reached from the hole before.
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

TEST_CASE("concave polygons, random on grids so small that corners lie on a line, are covered exactly", "[polygon]") {
    std::mt19937 random(7);
    int tried = 0;
    for (int k = 0; k < 600; ++k) {
        const std::uint32_t range = k % 2 == 0 ? 8 : 1000;
        Outline outline(5 + random() % 20);
        for (Point& place : outline) {
            place = {static_cast<int>(random() % range), static_cast<int>(random() % range)};
        }
        if (untangle(outline)) {
            if (rings::twice_area(outline) < 0) {
                std::reverse(outline.begin(), outline.end());
            }
            ++tried;
            check(outline);
        }
    }
    CHECK(tried > 300);
}

TEST_CASE("orientations are not rounded", "[polygon]") {
    struct Place {
        std::int64_t x, y;
    };
    // Units of 2^-53: the first corner goes over a diagonal by steps in which the products of doubles cannot tell the sides.
    constexpr std::int64_t one = std::int64_t{1} << 53;
    for (std::int64_t x = 0; x < 24; ++x) {
        for (std::int64_t y = 0; y < 24; ++y) {
            const std::vector<Place> outline{
                {one / 2 + x, one / 2 + y}, {12 * one, 12 * one}, {24 * one, 24 * one}, {0, 24 * one}, {-one, 12 * one}};
            CHECK(covers(cut(counted(5), standing<double>(outline, 2, 0)), outline));
        }
    }
}

TEST_CASE("polygons that cross themselves, and such without area, keep their boundary", "[polygon]") {
    std::mt19937 random(3);
    for (std::size_t count = 4; count < 60; ++count) {
        std::vector<double> xyz(3 * count);
        const std::uint32_t range = count % 3 == 0 ? 2 : 50;
        for (double& value : xyz) {
            value = static_cast<double>(random() % range) * 1e30;
        }
        CHECK(has_boundary(cut(counted(count), xyz), count));
    }
    CHECK(has_boundary(cut(counted(40), std::vector<double>(3 * 40, 0.1)), 40));
}

TEST_CASE("polygons of ten thousand corners are covered exactly, hostile ones refused", "[polygon]") {
    std::mt19937 random(5);
    std::vector<int> radii(10'000);
    for (int& radius : radii) {
        radius = 100'000'000 + static_cast<int>(random() % 100'000'000);
    }
    for (const Outline& outline : {ring(radii.size(), radii), comb(3000, 9000), pierced(2000)}) {
        CHECK(covers(cut(counted(outline.size()), standing<double>(outline, 2, 0)), outline));
    }
    const double triangle[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<std::uint32_t> corners(50'000);
    for (std::uint32_t& corner : corners) {
        corner = static_cast<std::uint32_t>(random() % 3);
    }
    std::vector<std::uint32_t> out(3 * corners.size());
    CHECK(PolygonTriangulator().triangulate(
              corners, {reinterpret_cast<const std::byte*>(triangle), 3 * sizeof(double), Number::f64}, out.data()) == 0);
}

}  // namespace
}  // namespace lamella
