#include "mesh/check/face_tree.hpp"

#include <cstddef>

#include "base/distribute.hpp"

namespace lamella {

namespace {

Array<std::uint32_t> distinct_faces(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel) {
    return indices_where(mesh.faces.size(), parallel, mesh.memory, [&](std::size_t face) {
        const bool again = face > 0 && vertex_set(mesh.faces[face]) == vertex_set(mesh.faces[face - 1]);
        return !again && stars.has_area(face);
    });
}

}  // namespace

FaceTree::FaceTree(const GridMesh& mesh, const EmbeddedStars& stars, const Parallel& parallel)
    : faces(distinct_faces(mesh, stars, parallel)), boxes(mesh.memory) {
    boxes.assign(
        faces.size(), [&](std::size_t item) { return Box::around(mesh.corners(mesh.faces[faces[item]])); }, parallel);
}

}  // namespace lamella
