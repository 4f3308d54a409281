// Measures of a mesh, for check() and orient_shells().
#pragma once

#include "base/parallel.hpp"
#include "lamella/check.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Fills in the mesh's box, grid, volume, area and number of triangles. Two calls of run(), which lead the progress on to
/// `progress`. O(n). The sums do not depend on threads. Throws Refused.
void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check);

}  // namespace lamella
