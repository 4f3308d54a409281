// Layers of a thousand contours and more for benchmarks of regions, as field tests of clipping libraries have them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella::bench {

struct Pattern {
    std::string name;
    std::int32_t offset;  ///< a distance to offset it by, grid units
    std::vector<std::vector<Point>> contours;
};

/// Each has about `share` of its contours or points, from 0 to 1. They are made when they are asked for.
std::vector<Pattern (*)(double share)> list_patterns();

}  // namespace lamella::bench
