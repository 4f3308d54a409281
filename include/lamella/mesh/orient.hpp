// Turns shells the right way round: outwards, or inwards where they bound a cavity.
//
//     const lamella::Result<lamella::OrientedMesh> oriented = lamella::orient_shells(mesh);
//     if (oriented && oriented->turned_shells > 0) {
//         lamella::SliceOptions options;
//         options.region.fill_rule = lamella::FillRule::non_zero;
//         const lamella::Result<lamella::SliceResult> sliced = lamella::slice(oriented->mesh, options);
//     }
//
// Slicing by FillRule::non_zero unites shells that overlap, but a shell turned inwards takes away from those that it
// overlaps. Where some shells of a mesh are turned at random, turn them first, and unite them then.
#pragma once

#include <cstdint>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/mesh/weld.hpp"

namespace lamella {

struct OrientedMesh {
    WeldedMesh mesh;           ///< the same triangles in the same order; equal vertices are one
    std::uint64_t shells = 0;  ///< sets of triangles connected over edges
    std::uint64_t turned_shells = 0;
    /// False: rays through too many triangles, or shells were turned beside open ones, which are around none. Some cavities
    /// may be turned outwards.
    bool complete = true;
};

struct OrientOptions {
    double mm_per_unit = 1;  ///< of the mesh's coordinates, more than 0
    double unit_mm = 0;      ///< 0: as slicing would choose
    Control control{};
};

/// Turns each closed shell that has a volume outwards, and inwards if it lies within an odd number of others: then it bounds
/// a cavity. A shell may touch the one that it lies within, but no face of the one crosses a face of the other, and all
/// places probed (eight vertices) lie inside. Shells that share an edge are one shell, and are turned together. Exact, on
/// the grid that slicing would use.
///
/// O(n log n) for meshes whose triangles are spread out; about 150 bytes a triangle beside the mesh. It takes about as long
/// as weld() and check() together. The answer does not depend on threads. Errors: those of weld() and check().
Result<OrientedMesh> orient_shells(const MeshView& mesh, const OrientOptions& options = {}) noexcept;

}  // namespace lamella
