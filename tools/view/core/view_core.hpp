// The page's engine: flat calls for its worker. Each call returns 1, or 0 where text() is an error of one line. What a call
// makes, the worker reads from buffers before the next call.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lamella/mesh.hpp"

namespace lamella::view {

/// At most `most_triangles` of the mesh, nine numbers each, about `centre` in mm: all of a small one, else a coarser one, of
/// which each vertex stands for those of a cell.
std::vector<float> preview(const MeshView& mesh, const std::array<double, 3>& centre, const Box& box,
                           std::uint64_t most_triangles);

}  // namespace lamella::view
