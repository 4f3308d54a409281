// Random polygons for the judges of regions.
#pragma once

#include <cstdint>
#include <random>

#include "regions/region.hpp"

namespace exact {

/// One to four polygons of together about `points` points, on a range of the grid from a few units up to all of it: random
/// ones, whose edges cross each other; walks of short steps; stars; rectangles. Some are given twice, a little moved or
/// backwards.
regions::Polygons random_polygons(std::mt19937& random, std::size_t points);

/// One to four polygons on the lattice 0 to 3, with edges in all directions that it has, some given twice or backwards. All
/// crossings lie on the grid: `cell` is divisible by every determinant of two directions.
inline constexpr std::int32_t cell = 360'360;
regions::Polygons random_on_small_lattice(std::mt19937& random);

}  // namespace exact
