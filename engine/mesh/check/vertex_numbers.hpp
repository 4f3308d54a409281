// The distinct vertices of a mesh on the grid, numbered.
#pragma once

#include <cstdint>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh/inspect.hpp"

namespace lamella {

struct VertexNumbers {
    Array<GridVertex> vertices;       ///< distinct, in Morton order
    Array<std::uint32_t> of_corners;  ///< three a triangle
    bool joined = false;              ///< some vertex of the grid stands for corners whose coordinates, as they are, differ
};

/// Seven calls of run(). Corners are numbered within ranges of triangles, then what the ranges have found in parts of the
/// order of vertices, each by a hash table in the cache: O(n) expected for the corners, O(v log v) for v vertices. `info`
/// holds the box and the unit. Coordinates are compared by hashes of 32 bits: that the only difference is missed has a
/// chance of 2^-32. Throws std::bad_alloc.
VertexNumbers number_vertices(const MeshView& mesh, const Transform& transform, const MeshInfo& info,
                              const Parallel& parallel, const Memory* memory);

}  // namespace lamella
