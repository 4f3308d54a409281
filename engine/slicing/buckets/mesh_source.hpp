// Triangles of a mesh in the caller's memory. Six triangles of an indexed mesh meet in a vertex, so each vertex is moved,
// rounded and looked up among the planes once, and not for each of its corners:
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

#include "lamella/mesh.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// Triangles in the caller's memory, with the numbers of the mesh.
class MeshSource : public TriangleSource {
public:
    MeshSource(const MeshView& mesh, const Placing& placing, const SharedFrame* frame, const SourceTools& tools) noexcept
        : TriangleSource({mesh.triangle_count, frame, placed_number(mesh, placing)}, tools),
          mesh_(mesh),
          placing_(placing) {}

protected:
    ~MeshSource() = default;

    const MeshView mesh_;
    const Placing placing_;
    double unit_mm_ = 0;  // from count() on
};

/// Corner by corner. Blocks that lie between two planes and have no degenerate triangle are read by measure() only.
class SoupSource final : public MeshSource {
public:
    using MeshSource::MeshSource;

    Bounds measure(double asked_mm) override;
    void count(double unit_mm) override;
    std::size_t scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) override;
};

/// Vertex by vertex: 17 bytes each. Gives the lists that SoupSource gives, and its errors.
class IndexedSource final : public MeshSource {
public:
    using MeshSource::MeshSource;

    /// True where vertices should be placed: the mesh is indexed, most vertices serve several triangles, and they are at
    /// most 2^23, so that they take at most 143 MB.
    static bool pays_for(const MeshView& mesh) noexcept {
        constexpr std::size_t most_vertices = std::size_t{1} << 23;
        return mesh.indices != nullptr && mesh.vertex_count <= mesh.triangle_count && mesh.vertex_count <= most_vertices;
    }

    Bounds measure(double asked_mm) override;  // in vertex_bounds.cpp
    void count(double unit_mm) override;
    std::size_t scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) override;

private:
    /// The vertices alone, as "triangles" whose first corner they are.
    MeshView vertices() const noexcept {
        return {.vertices = mesh_.vertices,
                .triangle_count = mesh_.vertex_count,
                .vertex_stride = mesh_.vertex_step(),
                .vertex_type = mesh_.vertex_type};
    }
    bool mark_used();
    void place_vertices();
};

/// Calls use(source) with the source that serves a mesh.
template <class Use>
void with_mesh_source(const MeshView& mesh, const Placing& placing, const SharedFrame* frame, const SourceTools& tools,
                      Use use) {
    if (IndexedSource::pays_for(mesh)) {
        IndexedSource source(mesh, placing, frame, tools);
        use(source);
    } else {
        SoupSource source(mesh, placing, frame, tools);
        use(source);
    }
}

}  // namespace lamella
