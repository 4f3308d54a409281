// Stage 4: triangles to the plane list of the first plane that cuts them (Algorithm 2), concurrently, by count, prefix sum
// and scatter: no locks, and nothing that depends on threads but the order within one plane's list, on which nothing
// depends.
//
// Two streaming reads of the input after the one for its bounds. The first counts; the second writes what is cut, and only
// that, as 48-byte records in plane order:
//
//     planes         0        1      2  ...
//     records     [ t7 t2 | t9 t4 | t1 | ...     list_begin = 0, 2, 4, 5, ...
#pragma once

#include <cstdint>

#include "2_grid/quantise.hpp"
#include "3_planes/plane_set.hpp"
#include "base/parallel.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// A triangle that at least one plane cuts. Vertices by height; the long edge runs from `lower` to `upper`, the short edges
/// from `lower` to `middle` and from `middle` to `upper`. A segment leaves the edge that its face walks downwards and
/// ends on the one that it walks upwards: that way the solid is on its left.
struct CrossedTriangle {
    GridVertex lower;
    GridVertex middle;
    GridVertex upper;
    std::uint32_t triangle;          ///< index in the input
    std::uint32_t middle_and_sense;  ///< first plane above `middle`, and in the top bit whether the long edge is the source
    PlaneIndex last;                 ///< one past the last plane that cuts it

    PlaneIndex middle_plane() const noexcept { return middle_and_sense & 0x7FFFFFFFU; }
    bool long_edge_is_source() const noexcept { return (middle_and_sense >> 31) != 0; }
};
static_assert(sizeof(CrossedTriangle) == 48, "the memory bound counts 48 bytes a crossed triangle");

struct Buckets {
    explicit Buckets(std::pmr::memory_resource* memory)
        : records(memory), list_begin(memory), segments(memory), crossed_mask(memory), counters(memory) {}

    Array<CrossedTriangle> records;   ///< by first plane
    Array<std::uint32_t> list_begin;  ///< k + 1: where each plane's list begins in `records`
    Array<std::uint32_t> segments;    ///< k: triangles that each plane cuts
    std::uint64_t segment_count = 0;  ///< m
    std::uint64_t degenerate = 0;

    Array<std::uint64_t> crossed_mask;  // scratch: a bit a triangle, so that the second read skips what is not cut
    Array<std::uint32_t> counters;      // scratch: per thread and plane
};

/// First read: degenerate triangles, the size of every list, and m, before anything of that size is allocated.
void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                     const Parallel& parallel, Buckets& buckets);

/// Second read: the records. Precondition: count_crossings() with the same arguments.
void scatter_triangles(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                       const Parallel& parallel, Buckets& buckets);

}  // namespace lamella
