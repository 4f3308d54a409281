// Welding: joins vertices that should be one, so that a cracked mesh closes. Slicing never does this by itself.
//
//     const lamella::Result<lamella::WeldedMesh> welded = lamella::weld(mesh, {.tolerance_mm = 0.01});
//     if (welded) {
//         const lamella::Result<lamella::SliceResult> sliced = lamella::slice(*welded);
//     }
#pragma once

#include <cstdint>

#include "lamella/array.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"
#include "lamella/slice.hpp"

namespace lamella {

/// The same triangles in the same order over fewer vertices, in memory of its own.
struct WeldedMesh {
    Array<std::byte> coordinates;  ///< three numbers a vertex, of the input's type and in its unit
    Array<std::uint32_t> indices;  ///< three a triangle
    CoordinateType coordinate_type = CoordinateType::f32;
    std::uint64_t vertex_count = 0;
    std::uint64_t joined = 0;    ///< distinct vertices that were moved onto another one
    double largest_move_mm = 0;  ///< of one of them
    double tolerance_mm = 0;     ///< that was asked for
    double mm_per_unit = 1;      ///< of the coordinates

    MeshView view() const noexcept {
        const std::size_t stride = 3 * (coordinate_type == CoordinateType::f32 ? sizeof(float) : sizeof(double));
        return MeshView::indexed(coordinates.data(), vertex_count, stride, coordinate_type, indices.span());
    }

    /// From the coordinates to mm.
    Transform to_mm() const noexcept { return Transform::scale(mm_per_unit); }
};

struct WeldOptions {
    double tolerance_mm = 0.01;
    double mm_per_unit = 1;  ///< of the mesh's coordinates, more than 0
    Control control{};
};

/// Joins vertices at most `tolerance_mm` apart. They are taken in the order of (x, y, z): each moves onto the nearest vertex
/// within the tolerance that was kept before it, or is kept. So no chain of close vertices collapses, no coordinate is made
/// up, and the answer depends on neither the order of the triangles nor threads. Triangles that lose a corner become
/// degenerate, which slicing drops and counts.
///
/// O(n log n) time for n triangles, on all threads but for one step: vertices that have another before them within the
/// tolerance, which are few where it is small, decide one after the other. Beside the answer 96 bytes a triangle for floats
/// and 192 for doubles, or 60 and 72 a distinct vertex where that is more. Errors: empty_mesh, bad_coordinate (not finite,
/// or beyond 1e9), invalid_argument (an index out of range, a tolerance that is neither 0 nor at least 1e-9 of the mesh's
/// units, 2^32 / 3 triangles, negative threads), out_of_memory, cancelled.
Result<WeldedMesh> weld(const MeshView& mesh, const WeldOptions& options = {}) noexcept;

/// slice(), with the mesh's unit applied before `options.transform`.
Result<SliceResult> slice(const WeldedMesh& mesh, const SliceOptions& options = {}) noexcept;

}  // namespace lamella
