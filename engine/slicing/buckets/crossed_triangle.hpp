// A crossed triangle, as the sweep needs it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "lamella/result.hpp"
#include "slicing/grid/mesh_edge.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// A triangle that at least one plane cuts. Vertices by height; the long edge runs from `lower` to `upper`, the short edges
/// from `lower` to `middle` and from `middle` to `upper`. A segment starts on the edge that its face runs down
/// and ends on the edge that it runs up, so the solid is on its left.
struct CrossedTriangle {
    GridVertex lower;
    GridVertex middle;
    GridVertex upper;
    union {
        std::uint32_t triangle;  ///< index in the input
        PlaneIndex first;        ///< of ListedTriangles, which have no input: the first plane that cuts it
    };
    std::uint32_t middle_and_source;  ///< first plane above `middle`, and in the top bit whether the long edge is the source
    PlaneIndex last;                  ///< one past the last plane that cuts it

    PlaneIndex middle_plane() const noexcept { return middle_and_source & 0x7FFFFFFFU; }
    bool long_edge_is_source() const noexcept { return (middle_and_source >> 31) != 0; }
};
static_assert(sizeof(CrossedTriangle) == 48, "the memory bound counts 48 bytes a crossed triangle");

/// The edge from a triangle's lowest vertex to its highest.
inline MeshEdge long_edge(const CrossedTriangle& t) noexcept {
    return MeshEdge::between(t.lower, t.upper);
}

/// The edge above the middle vertex, or the one below it. A branch would be mispredicted half of the time; the two lie side
/// by side in memory, so the address is computed instead.
inline MeshEdge short_edge(const CrossedTriangle& t, bool above_middle) noexcept {
    static_assert(offsetof(CrossedTriangle, lower) == 0 && offsetof(CrossedTriangle, middle) == sizeof(GridVertex) &&
                  offsetof(CrossedTriangle, upper) == 2 * sizeof(GridVertex));
    const char* at = reinterpret_cast<const char*>(&t) + sizeof(GridVertex) * static_cast<std::size_t>(above_middle);
    MeshEdge edge;
    for (std::uint64_t& word : edge.words) {
        std::memcpy(&word, at, sizeof word);
        at += sizeof word;
    }
    return edge;
}

/// The order of three vertices by height, and whether it is an odd permutation of them: then the facet walks the long edge
/// upwards. Indexed by (z1 < z0) + 2 (z2 < z1) + 4 (z2 < z0): a table instead of branches, which would be mispredicted.
struct HeightOrder {
    std::uint8_t lower, middle, upper, odd;
};
inline constexpr HeightOrder height_orders[8] = {
    {0, 1, 2, 0}, {1, 0, 2, 1}, {0, 2, 1, 1}, {0, 1, 2, 0}, {0, 1, 2, 0}, {1, 2, 0, 0}, {2, 0, 1, 0}, {2, 1, 0, 1},
};

inline const HeightOrder& height_order_of(std::int32_t z0, std::int32_t z1, std::int32_t z2) noexcept {
    return height_orders[(z1 < z0 ? 1U : 0U) + (z2 < z1 ? 2U : 0U) + (z2 < z0 ? 4U : 0U)];
}
inline const HeightOrder& height_order_of(const GridTriangle& v) noexcept {
    return height_order_of(v[0].z, v[1].z, v[2].z);
}

/// The top bit of CrossedTriangle::middle_and_source.
inline std::uint32_t source_bit(const HeightOrder& order) noexcept {
    return order.odd != 0 ? 0U : 1U << 31;
}

/// A record without its planes.
inline CrossedTriangle order_by_height(const GridTriangle& v, std::uint32_t triangle) noexcept {
    const HeightOrder& order = height_order_of(v);
    return {v[order.lower], v[order.middle], v[order.upper], {triangle}, source_bit(order), 0};
}

/// The numbers that the input gives to the edges of a crossed triangle: edge e leads from corner e to the next.
///
///     long edge      lower   middle   upper     lower short edge   upper short edge   long edge
///     walked down    c       c + 1    c + 2     c                  c + 1              c + 2
///     walked up      c       c + 2    c + 1     c + 2              c + 1              c            all modulo 3
struct EdgeNumbers {
    std::uint8_t lower_short;
    std::uint8_t upper_short;
    std::uint8_t long_edge;

    EdgeNumbers(const CrossedTriangle& t, std::uint8_t lowest_corner) noexcept {
        const std::uint8_t second = next(lowest_corner);
        const std::uint8_t third = next(second);
        lower_short = t.long_edge_is_source() ? lowest_corner : third;
        upper_short = second;
        long_edge = t.long_edge_is_source() ? third : lowest_corner;
    }

private:
    static std::uint8_t next(std::uint8_t corner) noexcept {
        return corner == 2 ? std::uint8_t{0} : static_cast<std::uint8_t>(corner + 1);
    }
};

/// The origin of the segment in which a plane cuts the triangle, as its facet runs.
inline PointOrigin origin_of(const CrossedTriangle& t, std::uint8_t lowest_corner, bool above_middle) noexcept {
    const EdgeNumbers edges(t, lowest_corner);
    const std::uint8_t short_edge = above_middle ? edges.upper_short : edges.lower_short;
    return t.long_edge_is_source() ? PointOrigin{t.triangle, 0, edges.long_edge, short_edge}
                                   : PointOrigin{t.triangle, 0, short_edge, edges.long_edge};
}

}  // namespace lamella
