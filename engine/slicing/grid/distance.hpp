// Distances in a plane, in doubles.
#pragma once

#include <algorithm>

#include "lamella/grid.hpp"

namespace lamella {

/// Of (x, y) from the nearest point of an edge; grid units.
inline double squared_distance(double x, double y, Point from, Point to) noexcept {
    const double dx = static_cast<double>(to.x) - from.x;
    const double dy = static_cast<double>(to.y) - from.y;
    const double px = x - from.x;
    const double py = y - from.y;
    const double square = dx * dx + dy * dy;
    const double along = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0;
    const double left_x = px - along * dx;
    const double left_y = py - along * dy;
    return left_x * left_x + left_y * left_y;
}

}  // namespace lamella
