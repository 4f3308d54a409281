// Which corner of each crossed triangle is its lowest: what a record lacks to number the triangle's edges as the input does.
#pragma once

#include "base/parallel.hpp"
#include "lamella/mesh.hpp"
#include "lamella/result.hpp"
#include "slicing/buckets/bucket.hpp"

namespace lamella {

/// Fills in `buckets.lowest_corners`. Precondition: scatter_triangles() with the same arguments. O(n).
void find_lowest_corners(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel,
                         Buckets& buckets);

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
