// The faces of a mesh, found by where they lie.
#pragma once

#include <cstdint>

#include "mesh/check/embedded_stars.hpp"
#include "mesh/check/grid_mesh.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

/// Without those that have no area. Of several faces on the same vertices, which follow one another in the mesh, it has the
/// first: so a body that was exported a thousand times costs no more than once.
struct FaceTree {
    Array<std::uint32_t> faces;  ///< ascending
    BoxTree<GridVertex> boxes;   ///< items as in `faces`

    /// O(n), in at most 13 calls of run(). Throws std::bad_alloc.
    FaceTree(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel);
};

}  // namespace lamella
