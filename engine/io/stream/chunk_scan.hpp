// The second pass over a file of triangles, as one thread works on it: which planes cut each triangle of a chunk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "io/stream/triangle_store.hpp"
#include "lamella/mesh.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/blocks.hpp"
#include "slicing/planes/plane_set.hpp"

namespace lamella {

class SoupScan;

/// Gives what count_crossings() gives for the whole mesh, chunk by chunk.
class ChunkScan {
public:
    /// `buffer_bytes` a triangle.
    ChunkScan(const Transform& transform, double unit_mm, const PlaneSet& planes, std::size_t chunk_triangles,
              std::size_t buffer_bytes);

    /// Room for a chunk as it lies in the file.
    std::span<std::byte> bytes() noexcept { return bytes_; }

    /// The triangles of `chunk` that planes cut, until the next call. Adds to counts() and degenerate(). Without `near`
    /// none is degenerate. Throws Refused.
    std::span<const CrossedTriangle> scan(const MeshView& chunk, bool near);

    PlaneCounts& counts() noexcept { return counts_; }
    std::uint64_t degenerate() const noexcept { return degenerate_; }

private:
    void scan_measured(const MeshView& chunk, const SoupScan& soup);
    template <class Reader>
    void scan_block(const Reader& read, const SoupScan& soup, std::size_t block, std::size_t triangles);
    template <class Reader>
    void scan_each(const Reader& read, std::size_t begin, std::size_t end, bool may_be_degenerate);
    template <class Reader>
    std::uint64_t find_degenerate(const Reader& read, std::size_t begin);
    void keep(const GridTriangle& vertices);

    Transform transform_;
    double unit_mm_;
    const PlaneSet& planes_;
    Parallel one_;
    BlockTable table_{nullptr};
    std::vector<std::byte> bytes_;
    std::vector<CrossedTriangle> found_;
    std::size_t found_count_ = 0;
    PlaneCounts counts_;
    std::uint64_t degenerate_ = 0;
};

}  // namespace lamella
