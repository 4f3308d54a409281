#include "slicing/buckets/bucket.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <utility>

#include "base/parallel.hpp"
#include "slicing/buckets/bucket_parts.hpp"
#include "slicing/buckets/soup_scan.hpp"

namespace lamella {

namespace {

/// The count of one part.
template <class Reader>
class PartCount {
public:
    PartCount(const Reader& read, const SoupScan& scan, const PlaneSet& planes, PartCounts counts)
        : read_(read), scan_(scan), planes_(planes), counts_(counts) {
        std::fill_n(counts_.starting, 2 * (std::size_t{planes.size()} + 1), 0U);
    }

    /// Triangles [begin, end), at most 64; returns which of them planes cut. Drops degenerate ones if there may be some.
    std::uint64_t count(std::size_t begin, std::size_t end, bool may_be_degenerate) {
        if (!scan_.usable() || end - begin < block_triangles) {
            return count_each(begin, end, may_be_degenerate);
        }
        SoupScan::Ranges ranges;
        std::uint64_t mask = scan_.ranges(begin, ranges);
        if (may_be_degenerate) {
            mask &= ~find_degenerate(begin, end);
        }
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const int t = std::countr_zero(crossed);
            add(ranges.first[t], ranges.last[t]);
        }
        return mask;
    }

    std::uint64_t degenerate() const noexcept { return degenerate_; }

private:
    std::uint64_t count_each(std::size_t begin, std::size_t end, bool may_be_degenerate) {
        std::uint64_t mask = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const GridTriangle v = read_(t);
            if (may_be_degenerate && is_degenerate(v)) {
                ++degenerate_;
                continue;
            }
            const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
            const PlaneIndex first = planes_.first_above(low);
            if (planes_.z(first) < high) {
                add(first, planes_.first_above(high));
                mask |= std::uint64_t{1} << (t - begin);
            }
        }
        return mask;
    }

    std::uint64_t find_degenerate(std::size_t begin, std::size_t end) {
        std::uint64_t mask = 0;
        for (std::size_t t = begin; t < end; ++t) {
            mask |= std::uint64_t{is_degenerate(read_(t))} << (t - begin);
        }
        degenerate_ += static_cast<std::uint64_t>(std::popcount(mask));
        return mask;
    }

    void add(PlaneIndex first, PlaneIndex last) {
        ++counts_.starting[first];
        ++counts_.ended[last];
    }

    const Reader& read_;
    const SoupScan& scan_;
    const PlaneSet& planes_;
    PartCounts counts_;
    std::uint64_t degenerate_ = 0;
};

/// The scatter of one part.
template <class Reader>
class PartScatter {
public:
    PartScatter(const Reader& read, const SoupScan& scan, const PlaneSet& planes, std::span<const PlaneIndex> reach_end,
                std::size_t part, Buckets& buckets, ReachingOutput& reaching)
        : read_(read),
          scan_(scan),
          planes_(planes),
          reach_end_(reach_end),
          part_(part),
          cursors_(buckets, part, planes.size()),
          records_(buckets.records.data()),
          reaching_(reaching) {}

    /// The triangles of a block with a bit in `crossed`.
    void scatter(std::size_t begin, std::uint64_t crossed, bool whole) {
        if (!scan_.usable() || !whole) {
            return scatter_each(begin, crossed);
        }
        SoupScan::Written written;
        std::uint64_t mask = scan_.write(begin, crossed, reach_end_.data(), cursors_.next_record, records_, written);
        for (; mask != 0; mask &= mask - 1) {
            const int t = std::countr_zero(mask);
            reaching_.add(part_, {written.record[t], written.first[t], written.last[t]});
        }
    }

private:
    void scatter_each(std::size_t begin, std::uint64_t crossed) {
        for (; crossed != 0; crossed &= crossed - 1) {
            const std::size_t t = begin + static_cast<std::size_t>(std::countr_zero(crossed));
            CrossedTriangle record = order_by_height(read_(t), static_cast<std::uint32_t>(t));
            const PlaneIndex first = planes_.first_above(record.lower.z);
            record.middle_and_source |= planes_.first_above(record.middle.z);
            record.last = planes_.first_above(record.upper.z);
            const std::uint32_t at = cursors_.next_record[first]++;
            records_[at] = record;
            if (record.last > reach_end_[first]) {
                reaching_.add(part_, {at, first, record.last});
            }
        }
    }

    const Reader& read_;
    const SoupScan& scan_;
    const PlaneSet& planes_;
    std::span<const PlaneIndex> reach_end_;
    std::size_t part_;
    PartCursors cursors_;
    CrossedTriangle* records_;
    ReachingOutput& reaching_;
};

}  // namespace

void sum_up(const PlaneSet& planes, std::size_t parts, Buckets& buckets) {
    const std::size_t k = planes.size();
    std::uint32_t begin = 0;
    std::int64_t active = 0;
    buckets.segment_count = 0;
    for (std::size_t plane = 0; plane < k; ++plane) {
        buckets.list_begin[plane] = begin;
        for (std::size_t part = 0; part < parts; ++part) {
            const PartCounts counts(buckets, part, k);
            const std::uint32_t starting = counts.starting[plane];
            active += starting;
            active -= counts.ended[plane];
            PartCursors(buckets, part, k).next_record[plane] = begin;
            begin += starting;
        }
        buckets.segments[plane] = static_cast<std::uint32_t>(active);
        buckets.segment_count += static_cast<std::uint64_t>(active);
    }
    buckets.list_begin[k] = begin;
}

void make_counters(const PlaneSet& planes, std::size_t parts, Buckets& buckets) {
    const std::size_t k = planes.size();
    buckets.counters.resize_discarding(parts * 2 * (k + 1));
    buckets.list_begin.resize_discarding(k + 1);
    buckets.segments.resize_discarding(k);
}

void count_crossings(const MeshView& mesh, const Transform& transform, double unit_mm, const BlockTable& blocks,
                     const PlaneSet& planes, const Parallel& parallel, Buckets& buckets) {
    const BucketParts parts(mesh.triangle_count, parallel);
    const std::size_t k = planes.size();
    assert(blocks.blocks.size() == parts.blocks());
    buckets.crossed_mask.resize_discarding(parts.blocks());
    buckets.touched.set_size(0);
    make_counters(planes, parts.count, buckets);
    PerWorker<std::uint64_t> degenerate(parts.count);
    const SoupScan scan(mesh, transform, unit_mm, planes);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run(parts.count, [&](std::size_t part, int) {
            PartCount counter(read, scan, planes, PartCounts(buckets, part, k));
            for (std::size_t block = parts.begin_block(part); block < parts.begin_block(part + 1); ++block) {
                if (block % blocks_between_stops == 0) {
                    parallel.stop_if_asked();
                }
                const std::size_t begin = block * block_triangles;
                const std::size_t end = std::min(begin + block_triangles, parts.triangles);
                const bool may_be_degenerate = blocks.may_be_degenerate(block, unit_mm);
                const bool skipped = !may_be_degenerate && lies_between_planes(blocks.blocks[block], unit_mm, planes);
                buckets.crossed_mask[block] = skipped ? 0 : counter.count(begin, end, may_be_degenerate);
            }
            degenerate[part] = counter.degenerate();
        });
    });
    buckets.degenerate = 0;
    degenerate.for_each([&buckets](std::uint64_t of_part) { buckets.degenerate += of_part; });
    sum_up(planes, parts.count, buckets);
}

std::size_t scatter_triangles(const MeshView& mesh, const Transform& transform, double unit_mm, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching) {
    const BucketParts parts(mesh.triangle_count, parallel);
    assert(reach_end.size() == std::size_t{planes.size()} + 1);
    buckets.records.resize_discarding(buckets.list_begin[planes.size()]);
    ReachingOutput output(reaching, parts.count);
    const SoupScan scan(mesh, transform, unit_mm, planes);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        parallel.run(parts.count, [&](std::size_t part, int) {
            PartScatter scatter(read, scan, planes, reach_end, part, buckets, output);
            for (std::size_t block = parts.begin_block(part); block < parts.begin_block(part + 1); ++block) {
                if (block % blocks_between_stops == 0) {
                    parallel.stop_if_asked();
                }
                const std::size_t begin = block * block_triangles;
                scatter.scatter(begin, buckets.crossed_mask[block], begin + block_triangles <= parts.triangles);
            }
        });
    });
    return output.finish();
}

}  // namespace lamella
