// What is measured of a mesh before its edges are looked at.
#pragma once

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "lamella/mesh/inspect.hpp"

namespace lamella {

/// The mesh's box, unit, volume, area and number of triangles; the rest is 0. Two calls of run(), between
/// which `boxed` is called. O(n). The sums do not depend on threads. Errors: those of measure_bounds() and choose_unit().
Result<MeshInfo> measure_mesh(const MeshView& mesh, const Transform& transform, double asked_mm, const Parallel& parallel,
                              FunctionRef<void()> boxed);

}  // namespace lamella
