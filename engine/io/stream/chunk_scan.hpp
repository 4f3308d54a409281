// The second pass over a file of triangles: which planes cut each of them.
#pragma once

#include <bit>

#include "base/guard.hpp"
#include "io/stream/triangle_store.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/buckets/soup_scan.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// The second pass, as one thread works on it: which planes cut each triangle of a chunk. Gives what count_crossings() gives
/// for the whole mesh, chunk by chunk.
class ChunkScan {
public:
    /// `buffer_bytes` a triangle.
    ChunkScan(const Placing& placing, double unit_mm, const PlaneSet& planes, std::size_t chunk_triangles,
              std::size_t buffer_bytes)
        : placing_(placing),
          unit_mm_(unit_mm),
          planes_(planes),
          one_({.threads = 1}),
          bytes_(chunk_triangles * buffer_bytes),
          found_(chunk_triangles),
          counts_(planes.size()) {}

    /// Room for a chunk as it lies in the file.
    std::span<std::byte> bytes() noexcept { return bytes_; }

    /// The triangles of `chunk` that planes cut, until the next call. Adds to counts() and degenerate(). Without `near`
    /// none is degenerate. Throws Refused.
    std::span<const CrossedTriangle> scan(const MeshView& chunk, bool near) {
        found_count_ = 0;
        const SoupScan soup(chunk, placing_, unit_mm_, planes_);
        if (soup.usable() && !near && chunk.triangle_count % block_triangles == 0) {
            for (std::size_t begin = 0; begin < chunk.triangle_count; begin += block_triangles) {
                found_count_ += soup.append(begin, ~std::uint64_t{0}, found_.data() + found_count_);
            }
        } else {
            scan_measured(chunk, soup);
        }
        const std::span<const CrossedTriangle> found = std::span(found_).first(found_count_);
        for (const CrossedTriangle& triangle : found) {
            counts_.add(triangle.first, triangle.last);
        }
        return found;
    }

    PlaneCounts& counts() noexcept { return counts_; }
    std::uint64_t degenerate() const noexcept { return degenerate_; }

private:
    /// Blocks that lie between planes are left out.
    void scan_measured(const MeshView& chunk, const SoupScan& soup) {
        require(measure_bounds(chunk, placing_, unit_mm_, one_, table_));  // refused where the file has changed meanwhile
        with_reader(chunk, placing_, unit_mm_, [&](const auto& read) {
            for (std::size_t block = 0; block < table_.blocks.size(); ++block) {
                scan_block(read, soup, block, chunk.triangle_count);
            }
        });
    }

    template <class Reader>
    void scan_block(const Reader& read, const SoupScan& soup, std::size_t block, std::size_t triangles) {
        const std::size_t begin = block * block_triangles;
        const std::size_t end = std::min(begin + block_triangles, triangles);
        const bool may_be_degenerate = table_.may_be_degenerate(block, unit_mm_);
        if (!may_be_degenerate && lies_between_planes(table_.blocks[block], unit_mm_, planes_)) {
            return;
        }
        if (!soup.usable() || end - begin < block_triangles) {
            scan_each(read, begin, end, may_be_degenerate);
            return;
        }
        const std::uint64_t wanted = may_be_degenerate ? ~find_degenerate(read, begin) : ~std::uint64_t{0};
        found_count_ += soup.append(begin, wanted, found_.data() + found_count_);
    }

    template <class Reader>
    void scan_each(const Reader& read, std::size_t begin, std::size_t end, bool may_be_degenerate) {
        for (std::size_t t = begin; t < end; ++t) {
            const GridTriangle v = read(t);
            if (may_be_degenerate && is_degenerate(v)) {
                ++degenerate_;
                continue;
            }
            keep(v);
        }
    }

    template <class Reader>
    std::uint64_t find_degenerate(const Reader& read, std::size_t begin) {
        std::uint64_t mask = 0;
        for (std::size_t t = 0; t < block_triangles; ++t) {
            mask |= std::uint64_t{is_degenerate(read(begin + t))} << t;
        }
        degenerate_ += static_cast<std::uint64_t>(std::popcount(mask));
        return mask;
    }

    /// If planes cut it.
    void keep(const GridTriangle& vertices) {
        CrossedTriangle triangle = order_by_height(vertices, 0);
        triangle.first = planes_.first_above(triangle.lower.z);
        if (planes_.z(triangle.first) < triangle.upper.z) {
            triangle.middle_and_source |= planes_.first_above(triangle.middle.z);
            triangle.last = planes_.first_above(triangle.upper.z);
            found_[found_count_++] = triangle;
        }
    }

    Placing placing_;
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
