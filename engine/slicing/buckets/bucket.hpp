// Puts each triangle in the list of the first plane that cuts it (Algorithm 2), concurrently, by count, prefix sum and
// scatter. There are no locks. Only the order within one plane's list depends on threads, and nothing depends on that order.
//
// The input is read twice after its bounds are measured. The first read counts; the second writes the triangles that are
// cut as 48-byte records in plane order:
//
//     planes         0        1      2  ...
//     records     [ t7 t2 | t9 t4 | t1 | ...     list_begin = 0, 2, 4, 5, ...
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/memory.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/blocks.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

struct Buckets {
    explicit Buckets(const Memory* memory)
        : records(memory),
          lowest_corners(memory),
          list_begin(memory),
          segments(memory),
          crossed_mask(memory),
          touched(memory),
          counters(memory) {}

    /// Gives back what the last call did not need. Throws std::bad_alloc.
    void trim() {
        fit(records);
        fit(lowest_corners);
        fit(list_begin);
        fit(segments);
        fit(crossed_mask);
        fit(touched);
        fit(counters);
    }

    Array<CrossedTriangle> records;      ///< by first plane
    Array<std::uint8_t> lowest_corners;  ///< of each record, where origins are asked for: see lowest_corners.hpp
    Array<std::uint32_t> list_begin;     ///< k + 1: where each plane's list begins in `records`
    Array<std::uint32_t> segments;       ///< k: triangles that each plane cuts
    std::uint64_t segment_count = 0;     ///< m
    std::uint64_t degenerate = 0;

    Array<std::uint64_t> crossed_mask;  // scratch: a bit a triangle, so that the second read skips what is not cut
    Array<std::uint32_t> touched;       // scratch: blocks that planes pass through, of a prepared mesh
    Array<std::uint32_t> counters;      // scratch: per thread and plane
};

/// A record whose triangle reaches beyond the planes that its first plane is swept with.
struct Reaching {
    std::uint32_t record;
    PlaneIndex first;
    PlaneIndex last;  ///< one past
};

/// Whether no plane comes between the lowest and the highest vertex of the block.
inline bool lies_between_planes(const TriangleBlock& block, double unit_mm, const PlaneSet& planes) noexcept {
    return to_even_grid(block.high_mm, unit_mm) < planes.z(planes.first_above(to_even_grid(block.low_mm, unit_mm)));
}

/// First read: degenerate triangles, the size of every list, and m, before anything of that size is allocated. Blocks that
/// lie between two planes and have no degenerate triangle are not read. `blocks` comes from measure_bounds().
void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, const BlockTable& blocks,
                     const PlaneSet& planes, const Parallel& parallel, Buckets& buckets);

/// Second read: the records, and, in no order, those of them whose triangles are cut by planes from reach_end[first plane]
/// on too: into `reaching`, which must have room for all; returns how many they are. `reach_end` has k + 1 numbers.
/// Precondition: count_crossings() with the same arguments.
std::size_t scatter_triangles(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching);

}  // namespace lamella
