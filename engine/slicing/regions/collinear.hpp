// Points within straight lines.
#pragma once

#include <cstdint>
#include <span>

#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Takes the points that lie between their neighbours off a closed contour that has an area, in place; returns how many are
/// left. O(points).
inline std::size_t drop_collinear(std::span<Point> ring) noexcept {
    std::size_t left = 0;
    for (const Point p : ring) {
        while (left >= 2 && sign_of_side(ring[left - 2], ring[left - 1], p) == 0) {
            --left;
        }
        ring[left++] = p;
    }
    while (left > 3 && sign_of_side(ring[left - 2], ring[left - 1], ring[0]) == 0) {
        --left;
    }
    std::size_t first = 0;
    while (left - first > 3 && sign_of_side(ring[left - 1], ring[first], ring[first + 1]) == 0) {
        ++first;
    }
    for (std::size_t i = first; i < left && first > 0; ++i) {
        ring[i - first] = ring[i];
    }
    return left - first;
}

}  // namespace lamella
