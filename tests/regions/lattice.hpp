// A lattice of 4 x 4 cells of 12 units, each cut into four triangles by its diagonals. Regions on it are sets of these.
#pragma once

#include <array>
#include <cstdint>

#include <catch2/catch.hpp>

#include "rings.hpp"

namespace lattice {

using lamella::Point;

constexpr int side = 4;
constexpr std::int32_t cell = 12;
constexpr int triangles = 4 * side * side;
using Cells = std::uint64_t;  ///< bit 4 (y * side + x) + t: bottom, right, top, left of a cell
static_assert(triangles == 64);

inline std::array<Point, 3> triangle_of(int number) {
    const std::int32_t x = number / 4 % side * cell;
    const std::int32_t y = number / 4 / side * cell;
    const Point corners[] = {{x, y}, {x + cell, y}, {x + cell, y + cell}, {x, y + cell}};
    return {corners[number % 4], corners[(number % 4 + 1) % 4], {x + cell / 2, y + cell / 2}};
}

/// How often contours of `part`, of a result or a layer, run around a point; requires that it lies on none.
template <class Contours>
int winding_around(const Contours& of, std::uint32_t part, Point p) {
    int winding = 0;
    for (const auto& contour : of.contours) {
        winding += contour.part == part ? rings::winding(of.points_of(contour), p).value() : 0;
    }
    return winding;
}

/// The triangles of a part; requires that contours wind once around what they hold.
template <class Contours>
Cells cells_of(const Contours& of, std::uint32_t part) {
    Cells cells = 0;
    for (int t = 0; t < triangles; ++t) {
        const auto [a, b, c] = triangle_of(t);
        const int winding = winding_around(of, part, {(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3});
        REQUIRE((winding == 0 || winding == 1));
        cells |= Cells(winding) << t;
    }
    return cells;
}

}  // namespace lattice
