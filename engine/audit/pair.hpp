// Checks that calls on a finished result make first: its parts lie within its arrays.
#pragma once

#include "base/parallel.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// Planes ascend, and the contours of layers and the points of contours lie within their arrays. Less than validate().
Status examine(const SliceResult& result);

/// The same, and the mesh can be what was sliced: as many triangles, each index in range, coordinates within the grid.
Result<Bounds> examine(const MeshView& mesh, const SliceResult& result, const Parallel& parallel);

/// The mesh can have been sliced by this transform on this grid: each index in range, coordinates within the grid.
Result<Bounds> examine(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel);

}  // namespace lamella
