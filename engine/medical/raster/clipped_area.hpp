// The area of what of a polygon lies within a rectangle.
#pragma once

#include <vector>

#include "lamella/result.hpp"

namespace lamella {

/// Positive for counter-clockwise polygons. O(points). Throws std::bad_alloc.
double area_within(std::vector<PointMm> polygon, PointMm min, PointMm max);

}  // namespace lamella
