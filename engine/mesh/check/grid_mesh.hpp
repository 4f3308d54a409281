// The mesh that check() works on: vertices and faces on the grid, in an order that depends on nothing but coordinates.
// Faults found in this order are the same for any order of the input and any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
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

/// The edges of a grid mesh with the faces at each. Sides are numbered 3 * face + corner, each running from that corner to
/// the next.
class EdgeTable {
public:
    struct Edge {
        std::uint32_t lower;
        std::uint32_t upper;
    };

    /// O(n log(faces at a vertex)), in eight calls of run(). `mesh` must outlive the table. Throws std::bad_alloc.
    EdgeTable(const GridMesh& mesh, const Parallel& parallel);

    /// By lower vertex, then upper.
    std::size_t size() const noexcept { return first_sides_.size() - 1; }
    Edge operator[](std::size_t edge) const noexcept;

    /// Ascending.
    std::span<const std::uint32_t> sides(std::size_t edge) const noexcept {
        return {sides_.data() + first_sides_[edge], first_sides_[edge + 1] - first_sides_[edge]};
    }
    static std::uint32_t face_of(std::uint32_t side) noexcept { return side / 3; }

    /// As many faces run one way along the edge as the other.
    bool is_balanced(std::size_t edge) const noexcept {
        const std::span<const std::uint32_t> own = sides(edge);
        const auto forward = std::count_if(own.begin(), own.end(), [&](std::uint32_t side) {
            const auto& corners = mesh_.faces[side / 3].corners;
            return corners[side % 3] < corners[(side % 3 + 1) % 3];
        });
        return 2 * static_cast<std::size_t>(forward) == own.size();
    }

    /// Edges that have not one face on either hand, ascending: one face, or more than two, or two that run the same way.
    const Array<std::uint32_t>& irregular() const noexcept { return irregular_; }
    /// Edges with one face, ascending.
    const std::vector<std::uint32_t>& boundary() const noexcept { return boundary_; }

    /// True if two vertices are joined by an edge. O(log n).
    bool joins(std::uint32_t a, std::uint32_t b) const noexcept;

private:
    const GridMesh& mesh_;
    Array<std::uint32_t> first_sides_;  ///< by edge, and the end of the last
    Array<std::uint32_t> sides_;
    Array<std::uint32_t> irregular_;
    std::vector<std::uint32_t> boundary_;
};

}  // namespace lamella
