// How far apart ends of open polylines may be to be joined.
#pragma once

#include <cmath>

#include "lamella/slice.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// The length asked for, or if that is gaps_by_mesh what the mesh's own box makes of it. By operations that round alike
/// everywhere.
inline double gap_length_mm(double asked_mm, const Bounds& mesh) noexcept {
    if (asked_mm != gaps_by_mesh) {
        return asked_mm;
    }
    double squares = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double side = mesh.max_mm[axis] - mesh.min_mm[axis];
        squares += side * side;
    }
    return std::sqrt(squares) / 100;
}

/// The length up to which joints may cross contours. By the mesh, cracks are closed whatever crosses them, since surfaces
/// overlap a little there; what lies within a wider gap may be a wall.
inline double crossing_gap_mm(double asked_mm, double length_mm) noexcept {
    return asked_mm == gaps_by_mesh ? length_mm / 10 : length_mm;
}

}  // namespace lamella
