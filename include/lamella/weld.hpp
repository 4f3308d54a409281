// Mending a mesh before it is sliced, which slicing never does by itself: vertices that should be one are joined, so that a
// cracked mesh closes; shells are turned the right way round.
//
//     const lamella::Result<lamella::WeldedMesh> welded = lamella::weld(mesh, 0.01);
//     if (welded) {
//         const lamella::Result<lamella::OrientedMesh> oriented = lamella::orient_shells(welded->view());
//         if (oriented) {
//             const auto united = lamella::slice(*oriented, {.region = {.fill_rule = lamella::FillRule::non_zero}});
//         }
//     }
//
// Slicing by FillRule::non_zero unites shells that overlap, but a shell turned inwards takes away from those that it
// overlaps. Where some shells of a mesh are turned at random, turn them first, and unite them then.
#pragma once

#include <cstdint>

#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// The same triangles in the same order over fewer vertices, in memory of its own.
struct WeldedMesh {
    Array<std::byte> coordinates;  ///< three numbers a vertex, of the input's type and in its unit
    Array<std::uint32_t> indices;  ///< three a triangle
    Number vertex_type = Number::f32;
    std::uint64_t vertex_count = 0;
    std::uint64_t joined = 0;    ///< distinct vertices that were moved onto another one
    double largest_move_mm = 0;  ///< of one of them
    double tolerance_mm = 0;     ///< that was asked for
    double mm_per_unit = 1;      ///< of the coordinates

    MeshView view() const noexcept {
        return {.vertices = coordinates.data(),
                .vertex_count = static_cast<std::size_t>(vertex_count),
                .triangle_count = indices.size() / 3,
                .indices = indices.data(),
                .vertex_type = vertex_type,
                .mm_per_unit = mm_per_unit};
    }
};

/// Joins vertices at most `tolerance_mm` apart. They are taken in the order of (x, y, z): each moves onto the nearest vertex
/// within the tolerance that was kept before it, or is kept. So no chain of close vertices collapses, no coordinate is made
/// up, and the answer depends on neither the order of the triangles nor threads. Triangles that lose a corner become
/// degenerate, which slicing drops and counts.
///
/// O(n log n) time for n triangles, on all threads but for one step: unless the tolerance is 0, vertices decide one after
/// the other. Beside the answer 96 bytes a triangle for floats and 192 for doubles. Errors: empty_mesh, bad_coordinate (not
/// finite, or beyond 1e9), invalid_argument (an index out of range, a tolerance that is neither 0 nor at least 1e-9 of the
/// mesh's units, 2^32 / 3 triangles, negative threads), out_of_memory, cancelled.
Result<WeldedMesh> weld(const MeshView& mesh, double tolerance_mm = 0.01, const Context& context = {}) noexcept;

struct OrientedMesh {
    WeldedMesh mesh;           ///< the same triangles in the same order; equal vertices are one
    std::uint64_t shells = 0;  ///< sets of triangles connected over edges
    std::uint64_t turned_shells = 0;
    /// False: rays through too many triangles, or shells were turned beside open ones, which are around none. Some cavities
    /// may be turned outwards.
    bool complete = true;

    MeshView view() const noexcept { return mesh.view(); }
};

/// Turns each closed shell that has a volume outwards, and inwards if it lies within an odd number of others: then it bounds
/// a cavity. A shell may touch the one that it lies within, but no face of the one crosses a face of the other, and all
/// places probed (eight vertices) lie inside. Shells that share an edge are one shell, and are turned together. Exact, on
/// the grid that slicing would use, `grid_mm` as Frame::grid_mm.
///
/// O(n log n) for meshes whose triangles are spread out; about 150 bytes a triangle beside the mesh. It takes about as long
/// as weld() and check() together. The answer does not depend on threads. Errors: those of weld() and check().
Result<OrientedMesh> orient_shells(const MeshView& mesh, double grid_mm = 0, const Context& context = {}) noexcept;

}  // namespace lamella
