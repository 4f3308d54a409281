// Welding: vertices that should be one and are not, joined, so that a cracked mesh closes. Slicing never does this by
// itself.
#pragma once

#include <cstdint>

#include "lamella/array.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

/// The same triangles in the same order over fewer vertices, in memory of its own.
struct WeldedMesh {
    Array<std::byte> coordinates;  ///< three numbers a vertex, of the input's type
    Array<std::uint32_t> indices;  ///< three a triangle
    CoordinateType number = CoordinateType::f32;
    std::uint64_t vertices = 0;
    std::uint64_t joined = 0;    ///< distinct vertices that were moved onto another one
    double largest_move_mm = 0;  ///< of one of them

    MeshView view() const noexcept {
        const std::size_t stride = 3 * (number == CoordinateType::f32 ? sizeof(float) : sizeof(double));
        return MeshView::indexed(coordinates.data(), vertices, stride, number, indices.span());
    }
};

struct WeldOptions {
    double tolerance_mm = 0.01;
    double mm_per_unit = 1;  ///< of the mesh's coordinates
    Control control{};       ///< one thread does the work
};

/// Joins vertices at most `tolerance_mm` apart. They are taken in the order of (x, y, z): each moves onto
/// the nearest vertex within the tolerance that was kept before it, or is kept. So no chain of close vertices collapses, no
/// coordinate is made up, and the outcome depends on neither the order of the triangles nor threads. Triangles that lose a
/// corner become degenerate, which slicing drops and counts.
///
/// O(n log n) time for n triangles, 60 bytes a triangle for floats and 108 for doubles beside the outcome. Errors:
/// empty_mesh, bad_coordinate (not finite, or beyond 1e9), invalid_argument (an index out of range, a tolerance that is
/// neither 0 nor at least 1e-9 of the mesh's units, 2^32 / 3 triangles), out_of_memory.
Result<WeldedMesh> weld(const MeshView& mesh, const WeldOptions& options = {}) noexcept;

}  // namespace lamella
