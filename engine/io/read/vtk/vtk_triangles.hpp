// The usual case of cells: nothing but triangles, which need not be looked at one by one before they are copied.
#pragma once

#include <span>

#include "io/read/vtk/vtk_cells.hpp"

namespace lamella {

/// Gives `mesh` the triangles of all `arrays`, if their cells are triangles of existing points. False: they are not, or do
/// not fit into memory; `mesh` and the budget are then as before, and cut_cells() tells what is wrong, if anything is.
bool copy_triangles(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh);

}  // namespace lamella
