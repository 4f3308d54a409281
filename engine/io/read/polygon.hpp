// Cuts faces of more than three corners into triangles, for all readers.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "lamella/mesh.hpp"

namespace lamella {

/// Coordinates as readers keep them: three numbers each, without alignment, `stride` bytes apart.
struct VertexCoordinates {
    const std::byte* first = nullptr;
    std::size_t stride = 0;
    Number number = Number::f32;

    std::array<double, 3> operator[](std::uint32_t vertex) const noexcept {
        return number == Number::f32 ? read<float>(vertex) : read<double>(vertex);
    }

    bool is_finite(std::uint32_t vertex) const noexcept {
        const std::array<double, 3> xyz = (*this)[vertex];
        return xyz[0] * 0 + xyz[1] * 0 + xyz[2] * 0 == 0;  // infinity times 0 is no number; without branches
    }

private:
    template <class Value>
    std::array<double, 3> read(std::uint32_t vertex) const noexcept {
        Value xyz[3];
        std::memcpy(xyz, first + vertex * stride, sizeof xyz);
        return {xyz[0], xyz[1], xyz[2]};
    }
};

/// True if the diagonal from the first to the third corner lies within the quad: both halves then have the same orientation.
/// False where a coordinate is not finite, as then the product is not.
bool splits_at_first(std::span<const std::uint32_t> quad, const VertexCoordinates& vertices);
/// Writes the triangles that the first corner makes with every other edge. Returns their number.
std::size_t fan(std::span<const std::uint32_t> corners, std::uint32_t* out);

/// Cuts polygons into triangles. Holds nothing but scratch memory, which is kept from polygon to polygon: one for each
/// thread. The same polygon always gives the same triangles.
///
/// Whatever the polygon's shape, the boundary of its triangles is the polygon itself, so that closed meshes stay closed.
/// Concave polygons, and those with holes that a bridge of two coincident edges joins to the outline, are covered exactly:
/// orientations are decided without rounding, in the projection along the axis next to the polygon's normal. A polygon that
/// crosses itself has no inside; some triangles with its boundary are given.
///
/// Cost: triangles and convex quads need no memory, convex polygons O(n), others about O(n log n).
class PolygonTriangulator {
public:
    /// Writes the corners.size() - 2 triangles to `out`, which has room for as many, three indices each, in the
    /// orientation of the polygon, and returns their number. Convex polygons become the fan of their first corner. 0:
    /// refused, because a hostile outline of thousands of corners would take minutes or more; `out` is then unspecified.
    /// Preconditions: at least three corners, each of them a vertex; finite coordinates. Throws std::bad_alloc.
    std::size_t triangulate(std::span<const std::uint32_t> corners, const VertexCoordinates& vertices, std::uint32_t* out);

    /// The most scratch memory that a polygon of so many corners takes, twice because vectors grow by copying.
    static constexpr std::size_t scratch_bytes(std::size_t corners) noexcept {
        return corners <= 4
                   ? 0
                   : 2 * (corners * (sizeof(Corner) + 2 * sizeof(std::uint32_t)) + most_nodes(corners) * sizeof(Node));
    }

private:
    struct Corner {
        double x = 0;
        double y = 0;
        std::uint32_t previous = 0;
        std::uint32_t next = 0;
    };

    /// A node of a tree over those corners that could lie in an ear: a box, and how many corners in it still can.
    struct Node {
        double low_x = 0;
        double low_y = 0;
        double high_x = 0;
        double high_y = 0;
        std::uint32_t begin = 0;  ///< in blockers_
        std::uint32_t end = 0;
        std::uint32_t children = 0;  ///< the first of two; 0: a leaf
        std::uint32_t parent = 0;
        std::uint32_t alive = 0;
    };

    /// Corners that keep a convex corner from being clipped: those in or on the triangle; only those strictly within;
    /// nothing. In the last mode any corner is clipped. All but the first are for polygons that touch or cross themselves.
    enum class Rule { untouched, nothing_within, convex, any };

    /// Every leaf but a lone one has more than four corners.
    static constexpr std::size_t most_nodes(std::size_t corners) noexcept { return corners / 2 + 1; }

    void project(std::span<const std::uint32_t> corners, const VertexCoordinates& vertices);
    bool is_convex() const;
    bool clip_ears(std::span<const std::uint32_t> corners, std::uint32_t* out);
    void build_tree();
    void split(std::uint32_t node);
    void forget(std::uint32_t corner);
    bool is_ear(std::uint32_t corner, Rule rule);
    bool blocked(std::uint32_t corner, Rule rule);
    bool misses(const Node& node, const Corner& a, const Corner& b, const Corner& c) const;
    bool blocks(std::uint32_t corner, std::uint32_t ear, Rule rule) const;
    bool turns_left(std::uint32_t corner) const;

    std::vector<Corner> corners_;
    std::vector<std::uint32_t> blockers_;
    std::vector<std::uint32_t> leaf_of_;  ///< of a corner; `no_leaf`: not in the tree
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> open_;  ///< nodes yet to be searched
    std::uint64_t steps_ = 0;
};

}  // namespace lamella
