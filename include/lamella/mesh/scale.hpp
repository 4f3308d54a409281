// Whether a mesh is too small for its grid, or too far from the origin for its numbers.
//
//     const lamella::Result<lamella::MeshInfo> info = lamella::inspect(mesh);
//     if (info) {
//         const lamella::MeshScale scale =
//             lamella::judge_scale(info->min_mm, info->max_mm, mesh.coordinate_type, info->unit_mm);
//         lamella::SliceOptions options;
//         if (scale.coarse_grid) {
//             options.unit_mm = scale.finest_unit_mm;  // as lamella::unit_by_box does
//         }
//     }
#pragma once

#include "lamella/mesh.hpp"

namespace lamella {

struct MeshScale {
    double diagonal_mm = 0;     ///< of the box
    double farthest_mm = 0;     ///< the largest magnitude of a coordinate
    double number_step_mm = 0;  ///< between neighbouring numbers there
    double finest_unit_mm = 0;  ///< the grid that unit_by_box chooses
    /// The diagonal is under 2^20 grid units: details may have been lost. finest_unit_mm tells whether a finer grid would
    /// do.
    bool coarse_grid = false;
    /// The step exceeds a tenth of the detail that matters: what was lost when the coordinates were stored shows. No grid
    /// brings it back.
    bool coarse_numbers = false;
};

/// The box and unit as inspect() or a SliceSummary states them; `number` holds the input's coordinates; `detail_mm`: the
/// layer height, or the side of a voxel. O(1), never fails.
MeshScale judge_scale(const double (&min_mm)[3], const double (&max_mm)[3], CoordinateType number, double unit_mm,
                      double detail_mm = 0.2) noexcept;

}  // namespace lamella
