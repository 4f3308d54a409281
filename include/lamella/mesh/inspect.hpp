// What a mesh is before it is cut: counts that tell whether it is closed.
//
//     const lamella::Result<lamella::MeshInfo> info = lamella::inspect(mesh);
//     if (info && !info->closed) {
//         std::printf("%zu edges with one face\n", static_cast<std::size_t>(info->boundary_edges));
//     }
//
// Source: section 1.3 of the paper, for what a closed mesh is. Where the faults are, check() says (mesh/check.hpp).
#pragma once

#include <cstdint>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

struct MeshInfo {
    std::uint64_t triangles = 0;
    std::uint64_t degenerate = 0;  ///< two equal vertices on the grid
    double min_mm[3] = {0, 0, 0};
    double max_mm[3] = {0, 0, 0};
    double volume_mm3 = 0;  ///< signed; meaningful for closed meshes
    double area_mm2 = 0;
    std::uint64_t edges = 0;           ///< distinct, degenerate triangles left out
    std::uint64_t boundary_edges = 0;  ///< with one face
    /// boundary_edges of the coordinates as they are. More than those of the grid: it joins vertices that nearly meet.
    std::uint64_t exact_boundary_edges = 0;
    std::uint64_t overfull_edges = 0;    ///< with more than two
    std::uint64_t mismatched_edges = 0;  ///< with two faces that run the same way (a flipped neighbour)
    std::uint64_t shells = 0;            ///< sets of triangles connected over edges
    double unit_mm = 0;                  ///< the grid on which vertices were compared

    /// Every edge has as many faces one way as the other.
    bool closed = false;
};

struct InspectOptions {
    double unit_mm = 0;     ///< 0: as slicing would choose
    Transform transform{};  ///< to mm, as in SliceOptions
    Control control{};
};

/// O(n) expected; 16 bytes a triangle beside the mesh. The answer does not depend on threads. Errors: empty_mesh,
/// invalid_argument (an index beyond the vertices, an unusable unit, negative threads), bad_coordinate (also: too large for
/// the unit asked for), out_of_memory, cancelled.
Result<MeshInfo> inspect(const MeshView& mesh, const InspectOptions& options = {}) noexcept;

}  // namespace lamella
