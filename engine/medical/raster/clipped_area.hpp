// The area of what of a polygon lies within a rectangle, and how long a contour is.
#pragma once

#include <span>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Positive for counter-clockwise polygons. O(points). Throws std::bad_alloc.
double area_within(std::vector<PointMm> polygon, PointMm min, PointMm max);

/// How long a closed contour is, grid units.
double perimeter_of(std::span<const Point> points) noexcept;

}  // namespace lamella
