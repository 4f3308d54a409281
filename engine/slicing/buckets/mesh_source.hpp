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
#include <variant>

#include "lamella/mesh.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/quantise.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

/// Triangles in the caller's memory, with the numbers of the mesh.
class MeshSource : public TriangleSource {
public:
    MeshSource(const MeshView& mesh, const Placing& placing, const SharedFrame* frame, const SourceTools& tools) noexcept
        : TriangleSource({mesh.triangle_count, frame, placed_number(mesh, placing)}, tools),
          mesh_(mesh),
          placing_(placing) {}

protected:
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
    std::size_t scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                        bool origins) override;
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

    Bounds measure(double asked_mm) override;
    void count(double unit_mm) override;
    std::size_t scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                        bool origins) override;

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

using AnySource = std::variant<std::monostate, SoupSource, IndexedSource>;

/// The source that serves a mesh, made in `source`.
TriangleSource& source_of(const MeshView& mesh, const Placing& placing, const SharedFrame* frame, const SourceTools& tools,
                          AnySource& source);

// Float soups in blocks of 64 triangles, sixteen at a time with AVX-512: the planes that cut them, and their records. Other
// meshes and processors take one triangle at a time, with the same result.

class SoupScan {
public:
    SoupScan(const MeshView& mesh, const Placing& placing, double unit_mm, const PlaneSet& planes,
             InstructionSet instructions) noexcept;

    /// True where this processor and mesh allow it.
    bool usable() const noexcept { return kernels_ != nullptr; }

    /// Planes from first[t] up to, but not with, last[t] cut triangle t.
    struct Ranges {
        PlaneIndex first[block_triangles];
        PlaneIndex last[block_triangles];
    };
    /// Triangles [begin, begin + 64), all of which must exist; returns which of them planes cut. Precondition: usable().
    std::uint64_t ranges(std::size_t begin, Ranges& ranges) const noexcept { return kernels_->ranges(*this, begin, ranges); }

    /// Writes a record for each triangle begin + t with bit t in `crossed`, as ShareRecords::write_each() does.
    /// Precondition: usable().
    void write(std::size_t begin, std::uint64_t crossed, ShareRecords& to) const {
        kernels_->write(*this, begin, crossed, to);
    }

    /// Writes a record with its first plane for each triangle begin + t with bit t in `wanted` that planes cut, one after
    /// the other; returns how many. Precondition: usable().
    std::size_t append(std::size_t begin, std::uint64_t wanted, CrossedTriangle* records) const noexcept {
        return kernels_->append(*this, begin, wanted, records);
    }

private:
    friend struct SoupKernel;
    struct Kernels {
        std::uint64_t (*ranges)(const SoupScan& scan, std::size_t begin, Ranges& ranges);
        void (*write)(const SoupScan& scan, std::size_t begin, std::uint64_t crossed, ShareRecords& to);
        std::size_t (*append)(const SoupScan& scan, std::size_t begin, std::uint64_t wanted, CrossedTriangle* records);
    };
    static const Kernels* kernels(InstructionSet instructions) noexcept;

    const std::byte* vertices_;
    std::int32_t stride_;
    float scale_;  // mm to half grid units
    const PlaneSet& planes_;
    float planes_per_unit_ = 0;         // 0: planes are found by the table
    const Kernels* kernels_ = nullptr;  // null: not usable
};

}  // namespace lamella
