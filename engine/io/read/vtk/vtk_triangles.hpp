// The usual case of cells: triangles only, which are copied and checked in one pass.
#pragma once

#include <span>

#include "io/read/vtk/vtk_cells.hpp"

namespace lamella {

/// Gives `mesh` the triangles of all `arrays`, if their cells are triangles of existing points. False: they are not, or do
/// not fit into memory. `mesh` and the budget are then as before, and cut_cells() reports what is wrong, if anything is.
bool copy_triangles(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh);

}  // namespace lamella
