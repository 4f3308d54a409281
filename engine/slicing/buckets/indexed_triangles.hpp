// Triangles of an indexed mesh. Six triangles meet in a vertex, so each vertex is moved, rounded and looked up among the
// planes once, and not for each of its corners:
//
//     vertices   x y z    on the grid   first plane above
//        v0      ...      ...           4
//        v1      ...                                        no triangle has it: it bounds nothing, and may be NaN
//        v2      ...      ...           6
//
//     triangles  v0 v2 v7         its first and last plane are the least and the greatest of three numbers
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// A vertex on the grid, and the first plane above it.
struct PlacedVertex {
    GridVertex at;
    PlaneIndex above;
};
static_assert(sizeof(PlacedVertex) == 16, "compared as one vector");

/// The vertices alone, as "triangles" whose first corner they are.
inline MeshView vertices_of(const MeshView& mesh) noexcept {
    return MeshView::strided_soup(mesh.vertices, mesh.vertex_count, mesh.stride, mesh.coordinate_type);
}

/// 17 bytes a vertex.
struct VertexTable {
    explicit VertexTable(const Memory* memory) : used(memory), placed(memory) {}

    /// Whether a mesh's vertices should be placed: it is indexed, most vertices serve several triangles, and they are at
    /// most 2^23, so that the table takes at most 143 MB.
    static bool pays_for(const MeshView& mesh) noexcept {
        constexpr std::size_t most_vertices = std::size_t{1} << 23;
        return mesh.indices != nullptr && mesh.vertex_count <= mesh.triangle_count && mesh.vertex_count <= most_vertices;
    }

    /// Gives back what the last call did not need. Throws std::bad_alloc.
    void trim() {
        fit(used);
        fit(placed);
    }

    /// Whether the vertex can be placed.
    bool has(std::size_t vertex) const noexcept { return used.empty() || used[vertex] != 0; }

    Array<std::uint8_t> used;    ///< 1 where a triangle has the vertex; empty where all vertices can be placed
    Array<PlacedVertex> placed;  ///< of those
};

/// Fills in `table.used`. As measure_bounds() for any mesh, which gives the error of a mesh that cannot be used. O(n).
/// Precondition: VertexTable::pays_for(mesh). In vertex_bounds.cpp.
Result<Bounds> measure_bounds(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel,
                              VertexTable& table, BlockTable& blocks);

/// As the functions of bucket.hpp of the same names do for any mesh, with the same lists. Counting fills in `table.placed`.
/// Precondition: measure_bounds() with this mesh and table.
void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, VertexTable& table,
                     const PlaneSet& planes, const Parallel& parallel, Buckets& buckets);
std::size_t scatter_triangles(const MeshView& mesh, const VertexTable& table, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching);

}  // namespace lamella
