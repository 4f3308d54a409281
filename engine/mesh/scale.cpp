#include "lamella/mesh/scale.hpp"

#include <algorithm>
#include <cmath>

#include "slicing/grid/bounds.hpp"

namespace lamella {

namespace {

constexpr double fewest_units = 1 << 20;  // along the diagonal
constexpr double coarsest_step = 0.1;     // of a detail

/// From the power of two below `value` to the next number of that type.
double number_step(double value, CoordinateType number) noexcept {
    return value == 0 ? 0 : std::ldexp(1.0, std::ilogb(value) - (number == CoordinateType::f32 ? 23 : 52));
}

}  // namespace

MeshScale judge_scale(const double (&min_mm)[3], const double (&max_mm)[3], CoordinateType number, double unit_mm,
                      double detail_mm) noexcept {
    MeshScale scale;
    for (int axis = 0; axis < 3; ++axis) {
        scale.farthest_mm = std::max({scale.farthest_mm, std::abs(min_mm[axis]), std::abs(max_mm[axis])});
    }
    scale.diagonal_mm = std::hypot(max_mm[0] - min_mm[0], max_mm[1] - min_mm[1], max_mm[2] - min_mm[2]);
    scale.number_step_mm = number_step(scale.farthest_mm, number);
    scale.finest_unit_mm = finest_unit(scale.farthest_mm);
    scale.coarse_grid = scale.diagonal_mm < fewest_units * unit_mm;
    scale.coarse_numbers = scale.number_step_mm > coarsest_step * detail_mm;
    return scale;
}

}  // namespace lamella
