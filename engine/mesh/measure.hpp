// For check() and orient_shells(): measures of a mesh, and its distinct vertices.
#pragma once

#include "base/parallel.hpp"
#include "lamella/check.hpp"
#include "lamella/weld.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Fills in the mesh's box, grid, volume, area and number of triangles. Two calls of run(), which lead the progress on to
/// `progress`. O(n). The sums do not depend on threads. Throws Refused.
void measure_mesh(const MeshView& mesh, const Frame& frame, const Parallel& parallel, double progress, MeshCheck& check);

/// The mesh with equal vertices made one. Precondition: it has been measured.
WeldedMesh weld_equal(const MeshView& mesh, const Parallel& parallel);

}  // namespace lamella
