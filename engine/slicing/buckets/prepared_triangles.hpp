// Triangles on the grid, ordered so that few planes read little of them: they are sorted into cells by height and by place.
// A cell of level c is 2^c units high. It holds the triangles that begin in it and are lower than that, though not lower
// than half of it unless the level is the lowest.
//
//     z  ^  |    |        |
//        |  |    |--------|  t3
//        |  |----|        |           level c:      cells [ t0 t2 | t1 | ...   of height 2^c
//        |  | t2 |        |           level c + 1:  cells [ t3 | ...           of height 2^(c+1)
//        |  |----| t1     |
//        |  | t0 |        |           A plane meets triangles of two cells at most in each level.
//
// Triangles of a cell keep the order of the input, in which neighbours lie close together. Over all of them, from the lowest
// level up, lie blocks of 64 with their z range, and over these blocks of 64 blocks. Only blocks that a plane passes through
// are read.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

struct PreparedTriangles {
    explicit PreparedTriangles(const Memory* memory) : triangles(memory), blocks(memory), super_blocks(memory) {}

    /// The least and the greatest z of some triangles.
    struct Range {
        std::int32_t low;
        std::int32_t high;
    };

    Array<CrossedTriangle>
        triangles;                 ///< those that are not degenerate; `last`: which corner is the lowest, in place of planes
    Array<Range> blocks;           ///< of 64 triangles
    Array<Range> super_blocks;     ///< of 64 blocks
    std::uint64_t degenerate = 0;  ///< left out

    std::size_t bytes() const noexcept;

    /// Reads the mesh twice, and writes it once: O(n). Memory: 48 bytes a triangle, and while it is made 8 for each cell and
    /// 2^16 triangles. `bounds` are those of the transformed mesh. Throws std::bad_alloc and Stopped.
    void build(const MeshView& mesh, const Transform& transform, const Bounds& bounds, double unit_mm,
               const Parallel& parallel);
};

/// As the functions of bucket.hpp of the same names do for a mesh: with the same lists, but for the order within each.
/// Where `origins` are asked for, `buckets.lowest_corners` is filled in too. O(n / 4096 + the triangles in blocks that
/// planes pass through).
void count_crossings(const PreparedTriangles& prepared, const PlaneSet& planes, const Parallel& parallel, Buckets& buckets);
std::size_t scatter_triangles(const PreparedTriangles& prepared, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching, bool origins);

}  // namespace lamella
