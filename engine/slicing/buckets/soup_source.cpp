#include <algorithm>
#include <bit>
#include <cassert>

#include "base/guard.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/soup_scan.hpp"
#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

/// Reads the blocks of a mesh: by vectors where that is possible, else triangle by triangle.
template <class Reader>
class BlockReader {
public:
    BlockReader(const Reader& read, const SoupScan& scan, const PlaneSet& planes) noexcept
        : read_(read), scan_(scan), planes_(planes) {}

    /// Triangles [begin, end), at most 64; returns which of them planes cut. Drops degenerate ones if there may be some.
    std::uint64_t count(std::size_t begin, std::size_t end, bool may_be_degenerate, ShareCounts& counts) const {
        if (!scan_.usable() || end - begin < block_triangles) {
            return count_each(begin, end, may_be_degenerate, counts);
        }
        SoupScan::Ranges ranges;
        std::uint64_t mask = scan_.ranges(begin, ranges);
        if (may_be_degenerate) {
            mask &= ~find_degenerate(begin, end, counts);
        }
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const int t = std::countr_zero(crossed);
            counts.add(ranges.first[t], ranges.last[t]);
        }
        return mask;
    }

    /// The triangles of a block with a bit in `crossed`.
    void scatter(std::size_t begin, std::uint64_t crossed, bool whole, const PlaneIndex* reach_end,
                 std::uint32_t* next_record, CrossedTriangle* records, ReachingWriter& reaching) const {
        if (!scan_.usable() || !whole) {
            scatter_each(begin, crossed, reach_end, next_record, records, reaching);
            return;
        }
        SoupScan::Written written;
        std::uint64_t mask = scan_.write(begin, crossed, reach_end, next_record, records, written);
        for (; mask != 0; mask &= mask - 1) {
            const int t = std::countr_zero(mask);
            reaching.add({written.record[t], written.first[t], written.last[t]});
        }
    }

private:
    std::uint64_t count_each(std::size_t begin, std::size_t end, bool may_be_degenerate, ShareCounts& counts) const {
        std::uint64_t mask = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const GridTriangle v = read_(t);
            if (may_be_degenerate && is_degenerate(v)) {
                ++counts.degenerate;
                continue;
            }
            const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
            const PlaneIndex first = planes_.first_above(low);
            if (planes_.z(first) < high) {
                counts.add(first, planes_.first_above(high));
                mask |= std::uint64_t{1} << (t - begin);
            }
        }
        return mask;
    }

    std::uint64_t find_degenerate(std::size_t begin, std::size_t end, ShareCounts& counts) const {
        std::uint64_t mask = 0;
        for (std::size_t t = begin; t < end; ++t) {
            mask |= std::uint64_t{is_degenerate(read_(t))} << (t - begin);
        }
        counts.degenerate += static_cast<std::uint64_t>(std::popcount(mask));
        return mask;
    }

    void scatter_each(std::size_t begin, std::uint64_t crossed, const PlaneIndex* reach_end, std::uint32_t* next_record,
                      CrossedTriangle* records, ReachingWriter& reaching) const {
        for (; crossed != 0; crossed &= crossed - 1) {
            const std::size_t t = begin + static_cast<std::size_t>(std::countr_zero(crossed));
            CrossedTriangle record = order_by_height(read_(t), static_cast<std::uint32_t>(t));
            const PlaneIndex first = planes_.first_above(record.lower.z);
            record.middle_and_source |= planes_.first_above(record.middle.z);
            record.last = planes_.first_above(record.upper.z);
            const std::uint32_t at = next_record[first]++;
            records[at] = record;
            if (record.last > reach_end[first]) {
                reaching.add({at, first, record.last});
            }
        }
    }

    const Reader& read_;
    const SoupScan& scan_;
    const PlaneSet& planes_;
};

}  // namespace

Bounds SoupSource::measure(double asked_mm) {
    return require(measure_bounds(mesh_, placing_, asked_mm, parallel_, buckets_.blocks));
}

void SoupSource::count(double unit_mm) {
    unit_mm_ = unit_mm;
    const SoupScan scan(mesh_, placing_, unit_mm, planes_);
    with_reader(mesh_, placing_, unit_mm, [&](const auto& read) {
        const BlockReader reader(read, scan, planes_);
        const auto count_block = [&](std::size_t begin, std::size_t end, ShareCounts& counts) {
            const std::size_t block = begin / block_triangles;
            const bool may_be_degenerate = buckets_.blocks.may_be_degenerate(block, unit_mm);
            const bool skipped = !may_be_degenerate && lies_between_planes(buckets_.blocks.blocks[block], unit_mm, planes_);
            return skipped ? 0 : reader.count(begin, end, may_be_degenerate, counts);
        };
        count_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_, count_block);
    });
}

std::size_t SoupSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) {
    assert(reach_end.size() == std::size_t{planes_.size()} + 1);
    const SoupScan scan(mesh_, placing_, unit_mm_, planes_);
    const std::size_t reaching_count = with_reader(mesh_, placing_, unit_mm_, [&](const auto& read) {
        const BlockReader reader(read, scan, planes_);
        const auto scatter_block = [&](std::size_t begin, std::uint64_t crossed, std::uint32_t* next_record,
                                       ReachingWriter& writer) {
            reader.scatter(begin, crossed, begin + block_triangles <= mesh_.triangle_count, reach_end.data(), next_record,
                           buckets_.records.data(), writer);
        };
        return scatter_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_, reaching,
                              scatter_block);
    });
    if (origins) {
        find_lowest_corners();
    }
    return reaching_count;
}

void MeshSource::find_lowest_corners() {
    constexpr std::size_t grain = std::size_t{1} << 13;
    buckets_.lowest_corners.resize_discarding(buckets_.records.size());
    with_reader(mesh_, placing_, unit_mm_, [&](const auto& read) {
        parallel_.run_ranges(buckets_.records.size(), grain, [&](std::size_t begin, std::size_t end, int) {
            parallel_.stop_if_asked();
            for (std::size_t record = begin; record < end; ++record) {
                buckets_.lowest_corners[record] = height_order_of(read(buckets_.records[record].triangle)).lower;
            }
        });
    });
}

}  // namespace lamella
