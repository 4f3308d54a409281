#include "io/stream/chunk_scan.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/guard.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/buckets/soup_scan.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

ChunkScan::ChunkScan(const Transform& transform, double unit_mm, const PlaneSet& planes, std::size_t chunk_triangles,
                     std::size_t buffer_bytes)
    : transform_(transform),
      unit_mm_(unit_mm),
      planes_(planes),
      one_({.threads = 1}),
      bytes_(chunk_triangles * buffer_bytes),
      counts_(planes.size()) {
    found_.reserve(chunk_triangles);
}

std::span<const StoredTriangle> ChunkScan::scan(const MeshView& chunk) {
    found_.clear();
    const Result<Bounds> bounds = measure_bounds(chunk, transform_, unit_mm_, one_, table_);
    if (!bounds) {  // the file has changed since it was measured
        throw Refused{bounds.error()};
    }
    const SoupScan soup(chunk, transform_, unit_mm_, planes_);
    scan_blocks(chunk, transform_, soup);
    return found_;
}

void ChunkScan::scan_blocks(const MeshView& chunk, const Transform& transform, const SoupScan& soup) {
    with_reader(chunk, transform, unit_mm_, [&](const auto& read) {
        for (std::size_t block = 0; block < table_.blocks.size(); ++block) {
            scan_block(read, soup, chunk, block);
        }
    });
}

template <class Reader>
void ChunkScan::scan_block(const Reader& read, const SoupScan& soup, const MeshView& chunk, std::size_t block) {
    const std::size_t begin = block * block_triangles;
    const std::size_t end = std::min(begin + block_triangles, chunk.triangle_count);
    const bool may_be_degenerate = table_.may_be_degenerate(block, unit_mm_);
    if (!may_be_degenerate && lies_between_planes(table_.blocks[block], unit_mm_, planes_)) {
        return;
    }
    if (!soup.usable() || end - begin < block_triangles) {
        scan_each(read, chunk, begin, end, may_be_degenerate);
        return;
    }
    SoupScan::Ranges ranges;
    std::uint64_t cut = soup.ranges(begin, ranges);
    if (may_be_degenerate) {
        cut &= ~find_degenerate(read, begin);
    }
    for (; cut != 0; cut &= cut - 1) {
        const auto t = static_cast<std::size_t>(std::countr_zero(cut));
        keep(chunk, begin + t, ranges.first[t], ranges.last[t]);
    }
}

template <class Reader>
void ChunkScan::scan_each(const Reader& read, const MeshView& chunk, std::size_t begin, std::size_t end,
                          bool may_be_degenerate) {
    for (std::size_t t = begin; t < end; ++t) {
        const GridTriangle v = read(t);
        if (may_be_degenerate && is_degenerate(v)) {
            ++degenerate_;
            continue;
        }
        const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
        const PlaneIndex first = planes_.first_above(low);
        if (planes_.z(first) < high) {
            keep(chunk, t, first, planes_.first_above(high));
        }
    }
}

template <class Reader>
std::uint64_t ChunkScan::find_degenerate(const Reader& read, std::size_t begin) {
    std::uint64_t mask = 0;
    for (std::size_t t = 0; t < block_triangles; ++t) {
        mask |= std::uint64_t{is_degenerate(read(begin + t))} << t;
    }
    degenerate_ += static_cast<std::uint64_t>(std::popcount(mask));
    return mask;
}

void ChunkScan::keep(const MeshView& chunk, std::size_t triangle, PlaneIndex first, PlaneIndex last) {
    StoredTriangle& stored = found_.emplace_back();
    if (chunk.indices != nullptr) {
        std::memcpy(stored.corners, chunk.indices + triangle * chunk.index_stride, 3 * sizeof(std::uint32_t));
    } else {
        std::memcpy(stored.corners, chunk.vertices + triangle * chunk.stride, sizeof stored.corners);
    }
    stored.first = first;
    stored.last = last;
    counts_.add(first, last);
}

}  // namespace lamella
