// The sources from which a slice reads its triangles (Algorithm 2):
//
//     soup_source       any mesh, corner by corner; blocks between planes are skipped
//     indexed_source    indexed meshes, each vertex placed once
//     prepared_source   prepared meshes, triangles on the grid already
//     listed_triangles  records in their lists already: a file, cut in ranges of layers
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/context.hpp"
#include "lamella/mesh.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

// Each triangle is put in the list of the first plane that cuts it (Algorithm 2), concurrently, by count, prefix sum and
// scatter. There are no locks. Only the order within one plane's list depends on threads, and nothing depends on that order.
//
// The input is read twice after its bounds are measured. The first read counts; the second writes the triangles that are
// cut as 48-byte records in plane order:
//
//     planes         0        1      2  ...
//     records     [ t7 t2 | t9 t4 | t1 | ...     list_begin = 0, 2, 4, 5, ...

/// A vertex on the grid, and the first plane above it.
struct PlacedVertex {
    GridVertex at;
    PlaneIndex above;
};
static_assert(sizeof(PlacedVertex) == 16, "compared as one vector");

struct Buckets {
    explicit Buckets(const Memory* memory)
        : records(memory),
          lowest_corners(memory),
          list_begin(memory),
          segments(memory),
          crossed_mask(memory),
          counters(memory),
          blocks(memory),
          used(memory),
          vertices(memory),
          touched(memory) {}

    /// Gives back what the last call did not need. Throws std::bad_alloc.
    void trim() {
        fit(records);
        fit(lowest_corners);
        fit(list_begin);
        fit(segments);
        fit(crossed_mask);
        fit(counters);
        fit(blocks.blocks);
        fit(used);
        fit(vertices);
        fit(touched);
    }

    Array<CrossedTriangle> records;      ///< by first plane
    Array<std::uint8_t> lowest_corners;  ///< corner of each record that is its lowest, where origins are asked for
    Array<std::uint32_t> list_begin;     ///< k + 1: where each plane's list begins in `records`
    Array<std::uint32_t> segments;       ///< k: triangles that each plane cuts
    std::uint64_t segment_count = 0;     ///< m
    std::uint64_t degenerate = 0;

    // Scratch of sources:
    Array<std::uint64_t> crossed_mask;  // a bit a triangle, so that the second read skips what is not cut
    Array<std::uint32_t> counters;      // per thread and plane
    BlockTable blocks;                  // of soups
    Array<std::uint8_t> used;           // of indexed meshes: 1 where a triangle has the vertex; empty: all can be placed
    Array<PlacedVertex> vertices;       // of indexed meshes: those that can be placed
    Array<std::uint32_t> touched;       // of prepared meshes: blocks that planes pass through
};

/// A record whose triangle reaches beyond the planes that its first plane is swept with.
struct Reaching {
    std::uint32_t record;
    PlaneIndex first;
    PlaneIndex last;  ///< one past
};

/// True where no plane comes between the lowest and the highest vertex of the block.
inline bool lies_between_planes(const TriangleBlock& block, double unit_mm, const PlaneSet& planes) noexcept {
    return !planes.any_between(to_even_grid(block.low_mm, unit_mm), to_even_grid(block.high_mm, unit_mm));
}

/// All that a source works with, which is kept from call to call.
struct SourceTools {
    const Parallel& parallel;
    const PlaneSet& planes;
    Buckets& buckets;
};

/// All that is known of triangles before they are read.
struct SourceInfo {
    std::uint64_t triangles;
    const SharedFrame* frame = nullptr;  ///< null: their own box chooses grid and planes
    Number number = Number::f64;         ///< heights are rounded to it where there is no frame
};

/// Fills in the buckets by functions that are called in their order; planes are built after measure(), and bands cut after
/// count(). A virtual call a stage, none a triangle. Throws Refused, Stopped, std::bad_alloc.
class TriangleSource {
public:
    TriangleSource(const TriangleSource&) = delete;
    TriangleSource& operator=(const TriangleSource&) = delete;

    /// The box of the placed triangles, of which there is one at least. `asked_mm`: the unit asked for, or 0.
    virtual Bounds measure(double asked_mm) = 0;
    /// First read: degenerate triangles, the size of every list, and m, before anything of that size is allocated. May be
    /// called again after the planes were.
    virtual void count(double unit_mm) = 0;
    /// Second read: the records, and, in no order, those of them whose triangles are cut by planes from reach_end[first
    /// plane] on too: into `reaching`, which must have room for all; returns how many they are. `reach_end` has k + 1
    /// numbers. Where `origins` are asked for, Buckets::lowest_corners too.
    virtual std::size_t scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) = 0;
    /// All bands are swept: what was lent goes back.
    virtual void give_back() noexcept {}

    const SourceInfo info;

protected:
    TriangleSource(const SourceInfo& own, const SourceTools& tools) noexcept
        : info(own), parallel_(tools.parallel), planes_(tools.planes), buckets_(tools.buckets) {}
    ~TriangleSource() = default;

    const Parallel& parallel_;
    const PlaneSet& planes_;
    Buckets& buckets_;
};

}  // namespace lamella
