// Shared by both formats of VTK: makes triangles of cells, which are polygons and triangle strips.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "io/read/vtk/vtk_file.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

enum class CellKind : std::uint8_t { polygons, strips };

/// Cells of one kind, in one of two layouts:
///
///     counted:  corners 3 a b c 4 d e f g         each cell's corners after their number, in 32 bits
///     else:     corners a b c d e f g, ends 3 7   all corners, and where each cell's end among them
struct CellArray {
    std::string_view name;  ///< for messages
    CellKind kind = CellKind::polygons;
    bool counted = false;
    std::uint64_t cells = 0;
    NumberArray corners{};
    NumberArray ends{};
    std::uint32_t first_point = 0;  ///< of those that the corners count from, in the mesh
    std::uint32_t point_count = 0;
};

/// Gives `mesh`, which has its vertices, the triangles of all `arrays`, in their order. Warns of cells without an area.
/// Throws errors. Memory: the indices, and little else unless there are polygons of millions of corners.
void cut_cells(VtkFile& file, std::span<const CellArray> arrays, MeshFile& mesh);

}  // namespace lamella
