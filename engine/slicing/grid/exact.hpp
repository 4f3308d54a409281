// On which side of an edge a point lies, exactly.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

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

// Exact arithmetic on grid vertices. Vertices are even, so they can be halved exactly. Differences of halves are within
// 2^30, their cross products within 2^61 (64 bits suffice), determinants within 2^93.

struct GridVector {
    std::int64_t x = 0;
    std::int64_t y = 0;
    std::int64_t z = 0;
};

inline GridVector half(const GridVertex& v) noexcept {
    return {v.x / 2, v.y / 2, v.z / 2};
}
inline GridVector operator-(const GridVector& a, const GridVector& b) noexcept {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline bool operator==(const GridVector& a, const GridVector& b) noexcept {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}
/// Of differences.
inline GridVector cross(const GridVector& a, const GridVector& b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Of a cross product and a difference, or of two differences.
inline Int128 dot(const GridVector& a, const GridVector& b) noexcept {
    return Int128{a.x} * b.x + Int128{a.y} * b.y + Int128{a.z} * b.z;
}

/// 1 when d lies on the side from which a, b, c are seen counter-clockwise; 0 when all four lie in a plane.
inline int side_of(const GridVector& a, const GridVector& b, const GridVector& c, const GridVector& d) noexcept {
    return sign_of(dot(cross(b - a, c - a), d - a));
}

// Boxes on the grid: of points in a plane, and of vertices in space.

/// The smaller number of each axis, and the larger one.
constexpr Point low_corner(Point a, Point b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y)};
}
constexpr Point high_corner(Point a, Point b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y)};
}
constexpr GridVertex low_corner(const GridVertex& a, const GridVertex& b) noexcept {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr GridVertex high_corner(const GridVertex& a, const GridVertex& b) noexcept {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// True if `a` has the larger number of some axis.
constexpr bool exceeds(Point a, Point b) noexcept {
    return a.x > b.x || a.y > b.y;
}
constexpr bool exceeds(const GridVertex& a, const GridVertex& b) noexcept {
    return a.x > b.x || a.y > b.y || a.z > b.z;
}

/// A box with its boundary, between two corners.
template <class Corner>
struct GridBox {
    static constexpr std::size_t axes = sizeof(Corner) / sizeof(std::int32_t);

    Corner low;
    Corner high;

    /// Meets nothing, and becomes whatever is included.
    static constexpr GridBox nothing() noexcept {
        std::array<std::int32_t, axes> most{};
        std::array<std::int32_t, axes> least{};
        most.fill(std::numeric_limits<std::int32_t>::max());
        least.fill(std::numeric_limits<std::int32_t>::min());
        return {bits_as<Corner>(most), bits_as<Corner>(least)};
    }
    static constexpr GridBox around(const Corner& a, const Corner& b) noexcept {
        return {low_corner(a, b), high_corner(a, b)};
    }
    static constexpr GridBox around(std::span<const Corner> corners) noexcept {
        GridBox box = nothing();
        for (const Corner& corner : corners) {
            box.include({corner, corner});
        }
        return box;
    }

    constexpr void include(const GridBox& other) noexcept {
        low = low_corner(low, other.low);
        high = high_corner(high, other.high);
    }
    constexpr bool meets(const GridBox& other) const noexcept {
        return !exceeds(low, other.high) && !exceeds(other.low, high);
    }
    constexpr bool holds(const Corner& corner) const noexcept { return meets({corner, corner}); }

    /// The corners' numbers by axis.
    struct Numbers {
        std::array<std::int32_t, axes> low;
        std::array<std::int32_t, axes> high;
    };
    constexpr Numbers numbers() const noexcept { return bits_as<Numbers>(*this); }

    friend constexpr auto operator<=>(const GridBox&, const GridBox&) = default;
};

using SpaceBox = GridBox<GridVertex>;
using FlatBox = GridBox<Point>;

constexpr std::int64_t width_of(const FlatBox& box) noexcept {
    return std::int64_t{box.high.x} - box.low.x;
}
constexpr std::int64_t height_of(const FlatBox& box) noexcept {
    return std::int64_t{box.high.y} - box.low.y;
}
constexpr FlatBox grown(const FlatBox& box, std::int32_t by) noexcept {
    return {{box.low.x - by, box.low.y - by}, {box.high.x + by, box.high.y + by}};
}

}  // namespace lamella
