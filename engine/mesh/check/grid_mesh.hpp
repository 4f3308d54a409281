// The mesh that check() works on: vertices and faces on the grid, in an order that depends on nothing but coordinates.
// Faults found in this order are the same for any order of the input and any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/check.hpp"
#include "lamella/weld.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Morton order (the Z-order curve) within a box: vertices that follow one another lie close to one another. Its bits take
/// turns:
///
///     x = 1 0 1      key = 1 0 0  0 1 1  1 1 0      of each axis the highest 21 bits that the box has
///     y = 0 1 1            x y z  x y z  x y z
///     z = 0 1 0
class MortonOrder {
public:
    /// In the box of `mesh`, on its grid.
    explicit MortonOrder(const MeshCheck& mesh) noexcept {
        std::int64_t extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis] = to_even_grid(mesh.box.min_mm[axis], mesh.grid_mm);
            extent = std::max(extent, std::int64_t{to_even_grid(mesh.box.max_mm[axis], mesh.grid_mm)} - low_[axis]);
        }
        shift_ = std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(extent))) - axis_bits);
    }

    /// Vertices that are closer than what 21 bits tell apart may have equal keys.
    std::uint64_t key(const GridVertex& v) const noexcept {
        return spread(v.x, low_[0]) << 2 | spread(v.y, low_[1]) << 1 | spread(v.z, low_[2]);
    }

private:
    static constexpr int axis_bits = 21;  ///< three fit 64

    /// Two zeros before each bit.
    std::uint64_t spread(std::int32_t coordinate, std::int64_t low) const noexcept {
        std::uint64_t bits = static_cast<std::uint64_t>(std::max<std::int64_t>(coordinate - low, 0)) >> shift_;
        bits &= 0x1FFFFF;
        bits = (bits | bits << 32) & 0x001F00000000FFFF;
        bits = (bits | bits << 16) & 0x001F0000FF0000FF;
        bits = (bits | bits << 8) & 0x100F00F00F00F00F;
        bits = (bits | bits << 4) & 0x10C30C30C30C30C3;
        return (bits | bits << 2) & 0x1249249249249249;
    }

    std::array<std::int64_t, 3> low_{};
    int shift_ = 0;
};

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
    explicit GridMesh(const Memory* memory) noexcept : vertices(memory), faces(memory) {}

    Array<GridVertex> vertices;   ///< distinct, in Morton order
    Array<Face> faces;            ///< by vertex_set(), then orientation, then source; those with two equal vertices left out
    std::vector<Face> collapsed;  ///< these, in the same order
    double grid_mm = 0;
    bool joined = false;  ///< some vertex stands for corners that differ before rounding

    std::array<GridVertex, 3> corners(const Face& face) const noexcept {
        return {vertices[face.corners[0]], vertices[face.corners[1]], vertices[face.corners[2]]};
    }
};

/// O(n log n), in fourteen calls of run(). `measured` holds the box and the grid. Precondition: indices in range,
/// coordinates within the grid, fewer than 2^32 / 3 triangles. Throws std::bad_alloc.
GridMesh make_grid_mesh(const MeshView& mesh, const Frame& frame, const MeshCheck& measured, const Parallel& parallel);

/// The faces of a mesh whose equal vertices are one, with vertices that have no place.
GridMesh make_exact_mesh(const WeldedMesh& mesh, const Parallel& parallel);

}  // namespace lamella
