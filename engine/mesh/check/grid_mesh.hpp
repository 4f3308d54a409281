// The mesh that check() works on: vertices and faces on the grid, in an order that depends on nothing but coordinates.
// What is found in this order is the same for any order of the input and any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/grid.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh/inspect.hpp"

namespace lamella {

/// Corners as vertex numbers, the smallest first, in the orientation of the input; and its triangle there.
struct Face {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t source;
};

/// Faces with the same three vertices, in either orientation, have equal keys.
inline std::array<std::uint32_t, 3> vertex_set(const Face& face) noexcept {
    const auto [a, b, c] = face.corners;
    return b < c ? std::array{a, b, c} : std::array{a, c, b};
}

struct GridMesh {
    const Memory* memory;         ///< for arrays that are as large as the mesh
    Array<GridVertex> vertices;   ///< distinct, in Morton order
    Array<Face> faces;            ///< by vertex_set(), then orientation, then source; those with two equal vertices left out
    std::vector<Face> collapsed;  ///< these, in the same order
    double unit_mm = 0;
    bool joined = false;  ///< some vertex stands for corners that differ before rounding

    std::array<GridVertex, 3> corners(const Face& face) const noexcept {
        return {vertices[face.corners[0]], vertices[face.corners[1]], vertices[face.corners[2]]};
    }
};

/// O(n log n), in eleven calls of run(). `info` holds the box and the unit. Precondition: indices in range, coordinates
/// within the grid, fewer than 2^32 / 3 triangles. Throws std::bad_alloc.
GridMesh make_grid_mesh(const MeshView& mesh, const Transform& transform, const MeshInfo& info, const Parallel& parallel,
                        const Memory* memory);

}  // namespace lamella
