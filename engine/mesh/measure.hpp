// Measures and counts of a mesh, for inspect() and check().
#pragma once

#include <cstdint>

#include "base/parallel.hpp"
#include "lamella/mesh/inspect.hpp"

namespace lamella {

/// The mesh's box, unit, volume, area and number of triangles; the rest is 0. Two calls of run(), which lead the progress on
/// to `progress`. O(n). The sums do not depend on threads. Errors: those of measure_bounds() and choose_unit().
Result<MeshInfo> measure_mesh(const MeshView& mesh, const Transform& transform, double asked_mm, const Parallel& parallel,
                              double progress);

/// Fills in what `info` counts, by the faces that meet at each edge (paper 1.3: closed meshes). Triangles with two vertices
/// at one place are left out. Six calls of run(), or twelve where the grid joins vertices or lets triangles collapse. O(n)
/// expected; 16 bytes a triangle (32 from 2^32 / 3 triangles on) and up to two more beside the mesh. The counts do not
/// depend on threads. Precondition: indices in range, coordinates within the grid that `info` names. Throws std::bad_alloc.
void count_edges(const MeshView& mesh, const Transform& transform, const Parallel& parallel, MeshInfo& info);

/// MeshInfo::exact_boundary_edges alone. As much work as all of count_edges().
std::uint64_t count_exact_boundary(const MeshView& mesh, const Parallel& parallel);

}  // namespace lamella
