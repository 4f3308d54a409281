// Exact products of points in 128 bits: simpler than the faster ones in nesting/inside.hpp.
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

/// The sign of side_of_line(), which takes 64 bits: each of its two products has 63, and their difference is not formed.
constexpr int sign_of_side(Point a, Point b, Point p) noexcept {
    const std::int64_t left = (std::int64_t{b.x} - a.x) * (std::int64_t{p.y} - a.y);
    const std::int64_t right = (std::int64_t{b.y} - a.y) * (std::int64_t{p.x} - a.x);
    return (left > right) - (left < right);
}

}  // namespace lamella
