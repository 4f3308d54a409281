// On which side of an edge a point lies, exactly.
#pragma once

#include "base/numbers.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Twice the signed area of the triangle (origin, u, v).
constexpr Int128 cross(Point u, Point v) noexcept {
    return Int128{u.x} * v.y - Int128{u.y} * v.x;
}

/// Positive if p lies left of the line from a to b.
constexpr Int128 side_of_line(Point a, Point b, Point p) noexcept {
    return (Int128{b.x} - a.x) * (Int128{p.y} - a.y) - (Int128{b.y} - a.y) * (Int128{p.x} - a.x);
}

static_assert(grid_limit <= 1 << 30,
              "products of two coordinate differences must fit 63 bits, so that they compare exactly");

/// The sign of side_of_line(): +1 where p lies left of a -> b, 0 on its line, -1 right. The products are compared, never
/// subtracted: their difference could overflow.
constexpr int side_of(Point a, Point b, Point p) noexcept {
    const std::int64_t left = (std::int64_t{b.x} - a.x) * (std::int64_t{p.y} - a.y);
    const std::int64_t right = (std::int64_t{b.y} - a.y) * (std::int64_t{p.x} - a.x);
    return (left > right) - (left < right);
}

/// Whether two edges cross at a point that is an end of neither.
constexpr bool edges_cross(Point a, Point b, Point c, Point d) noexcept {
    return side_of(a, b, c) * side_of(a, b, d) < 0 && side_of(c, d, a) * side_of(c, d, b) < 0;
}

}  // namespace lamella
