// 128-bit integers: sums of products of grid coordinates stay exact.
#pragma once

#include <cstdint>

#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella {

__extension__ using Int128 = __int128;

constexpr Int128 to_int128(Wide wide) noexcept {
    return static_cast<Int128>(wide.high) * (static_cast<Int128>(1) << 64) + static_cast<Int128>(wide.low);
}

/// Twice the signed area of the triangle (origin, u, v).
constexpr Int128 cross(Point u, Point v) noexcept {
    return static_cast<Int128>(u.x) * v.y - static_cast<Int128>(u.y) * v.x;
}

/// Positive when p lies left of the line from a to b. Differences take 33 bits, so their products need more than 64.
constexpr Int128 side_of_line(Point a, Point b, Point p) noexcept {
    const std::int64_t ax = std::int64_t{b.x} - a.x;
    const std::int64_t ay = std::int64_t{b.y} - a.y;
    return static_cast<Int128>(ax) * (std::int64_t{p.y} - a.y) - static_cast<Int128>(ay) * (std::int64_t{p.x} - a.x);
}

}  // namespace lamella
