// Exact arithmetic on grid vertices. Vertices are even, so they can be halved exactly. Differences of halves are within
// 2^30, their cross products within 2^61 (64 bits suffice), determinants within 2^93.
#pragma once

#include <cstdint>

#include "base/numbers.hpp"
#include "lamella/grid.hpp"

namespace lamella {

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

}  // namespace lamella
