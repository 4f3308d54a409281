// Exact geometry of points in a plane, by which tests judge what the engine has made. It shares only types with the engine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "lamella/grid.hpp"

namespace oracle {

__extension__ using Int128 = __int128;

/// Twice the area of the triangle: positive if p lies left of the line from a to b.
inline Int128 side(lamella::Point a, lamella::Point b, lamella::Point p) {
    return (Int128{b.x} - a.x) * (Int128{p.y} - a.y) - (Int128{b.y} - a.y) * (Int128{p.x} - a.x);
}

inline int sign(Int128 value) {
    return (value > 0) - (value < 0);
}

inline bool on_edge(lamella::Point p, lamella::Point a, lamella::Point b) {
    return side(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
           p.y <= std::max(a.y, b.y);
}

/// Whether two edges cross at a point that is an end of neither.
inline bool edges_cross(lamella::Point a, lamella::Point b, lamella::Point c, lamella::Point d) {
    return sign(side(a, b, c)) * sign(side(a, b, d)) < 0 && sign(side(c, d, a)) * sign(side(c, d, b)) < 0;
}

inline Int128 twice_area(std::span<const lamella::Point> ring) {
    Int128 sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        sum += side({}, ring[i], ring[(i + 1) % ring.size()]);
    }
    return sum;
}

/// Winding number of a closed ring around a point that lies on none of its edges.
inline int winding(std::span<const lamella::Point> ring, lamella::Point p) {
    int turns = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const lamella::Point a = ring[i];
        const lamella::Point b = ring[(i + 1) % ring.size()];
        if ((a.y <= p.y) != (b.y <= p.y)) {
            turns += a.y <= p.y ? side(a, b, p) > 0 : -(side(a, b, p) < 0);
        }
    }
    return turns;
}

}  // namespace oracle
