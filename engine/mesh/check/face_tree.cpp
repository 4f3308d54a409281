#include "mesh/check/face_tree.hpp"

#include <cstddef>

#include "base/distribute.hpp"
#include "slicing/grid/grid_vector.hpp"

namespace lamella {

namespace {

Array<std::uint32_t> distinct_faces(const GridMesh& mesh, const Parallel& parallel) {
    return indices_where(mesh.faces.size(), parallel, mesh.memory, [&](std::size_t face) {
        const bool again = face > 0 && vertex_set(mesh.faces[face]) == vertex_set(mesh.faces[face - 1]);
        if (again) {
            return false;
        }
        const auto [a, b, c] = mesh.corners(mesh.faces[face]);
        return !(cross(half(b) - half(a), half(c) - half(a)) == GridVector{});
    });
}

}  // namespace

FaceTree::FaceTree(const GridMesh& mesh, const Parallel& parallel)
    : faces(distinct_faces(mesh, parallel)),
      boxes(
          faces.size(), [&](std::size_t item) { return Box::around(mesh.corners(mesh.faces[faces[item]])); }, parallel,
          mesh.memory) {}

}  // namespace lamella
