// Results put together by hand, with numbers that the expected texts can be worked out from.
#pragma once

#include <vector>

#include "lamella/result.hpp"

namespace lamella::write_test {

struct Ring {
    Role role;
    std::vector<Point> points;
};

/// On a grid of `grid_mm`: one layer of height 0.5 mm for each list of rings, the first at 0.25 mm.
SliceResult result_of(const std::vector<std::vector<Ring>>& layers, double grid_mm);

/// A square with a square hole, 10 and 4 mm wide, on a grid of 0.5 mm; then an empty layer; then an open polyline.
SliceResult square_with_hole();

}  // namespace lamella::write_test
