// Points within straight lines.
#pragma once

#include <cstdint>
#include <span>

#include "lamella/grid.hpp"

namespace lamella {

/// Whether `b` lies on the line through `a` and `c`.
constexpr bool is_collinear(Point a, Point b, Point c) noexcept {
    return (std::int64_t{b.x} - a.x) * (std::int64_t{c.y} - b.y) == (std::int64_t{b.y} - a.y) * (std::int64_t{c.x} - b.x);
}

/// Takes the points that lie between their neighbours off a closed contour that has an area, in place; returns how many are
/// left. O(points).
inline std::size_t drop_collinear(std::span<Point> ring) noexcept {
    std::size_t left = 0;
    for (const Point p : ring) {
        while (left >= 2 && is_collinear(ring[left - 2], ring[left - 1], p)) {
            --left;
        }
        ring[left++] = p;
    }
    while (left > 3 && is_collinear(ring[left - 2], ring[left - 1], ring[0])) {
        --left;
    }
    std::size_t first = 0;
    while (left - first > 3 && is_collinear(ring[left - 1], ring[first], ring[first + 1])) {
        ++first;
    }
    for (std::size_t i = first; i < left && first > 0; ++i) {
        ring[i - first] = ring[i];
    }
    return left - first;
}

}  // namespace lamella
