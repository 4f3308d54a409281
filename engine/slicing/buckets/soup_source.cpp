#include <algorithm>
#include <bit>

#include "base/guard.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

/// A triangle on the grid, as count_each() reads it.
struct SoupTriangle {
    GridTriangle v;
    const PlaneSet& all_planes;

    bool is_degenerate() const noexcept { return lamella::is_degenerate(v); }
    PlaneRange planes() const noexcept {
        const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
        return all_planes.between(low, high);
    }
};

/// The degenerate ones of a whole block.
template <class Read>
std::uint64_t find_degenerate(const Read& read, std::size_t begin, ShareCounts& counts) {
    std::uint64_t mask = 0;
    for (std::size_t t = 0; t < block_triangles; ++t) {
        mask |= std::uint64_t{is_degenerate(read(begin + t))} << t;
    }
    counts.degenerate += static_cast<std::uint64_t>(std::popcount(mask));
    return mask;
}

/// As ShareRecords::write_each(), but read once, which takes longer than to wait for memory.
template <class Reader>
void scatter_each(const Reader& read, const PlaneSet& planes, std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
    for (; crossed != 0; crossed &= crossed - 1) {
        const std::size_t t = begin + static_cast<std::size_t>(std::countr_zero(crossed));
        const GridTriangle v = read(t);
        CrossedTriangle record = order_by_height(v, static_cast<std::uint32_t>(t));
        record.middle_and_source |= planes.first_above(record.middle.z);
        record.last = planes.first_above(record.upper.z);
        const PlaneRange cut{planes.first_above(record.lower.z), record.last};
        if (!cut.meets(to.tier)) {
            continue;
        }
        const std::uint32_t at = to.take_place(cut);
        to.records[at] = record;
        if (to.lowest_corners != nullptr) {
            to.lowest_corners[at] = height_order_of(v).lower;
        }
    }
}

}  // namespace

Bounds SoupSource::measure(double asked_mm) {
    buckets_.blocks.instructions = instructions_;
    return require(measure_bounds(mesh_, placing_, asked_mm, parallel_, buckets_.blocks));
}

void SoupSource::count(double unit_mm) {
    unit_mm_ = unit_mm;
    const SoupScan scan(mesh_, placing_, unit_mm, planes_, instructions_);
    with_reader(mesh_, placing_, unit_mm, [&](const auto& read) {
        const auto count_block = [&](std::size_t begin, std::size_t end, ShareCounts& counts) -> CrossedBlock {
            const std::size_t block = begin / block_triangles;
            const bool may_be_degenerate = buckets_.blocks.may_be_degenerate(block, unit_mm);
            const bool skipped = !may_be_degenerate && lies_between_planes(buckets_.blocks.blocks[block], unit_mm, planes_);
            if (skipped) {
                return {};
            }
            if (!scan.usable() || end - begin < block_triangles) {
                const auto triangle = [&](std::size_t t) { return SoupTriangle{read(t), planes_}; };
                return count_each(triangle, begin, end, may_be_degenerate, counts);
            }
            SoupScan::Ranges ranges;
            CrossedBlock crossed{scan.ranges(begin, ranges)};
            if (may_be_degenerate) {
                crossed.mask &= ~find_degenerate(read, begin, counts);
            }
            for (std::uint64_t left = crossed.mask; left != 0; left &= left - 1) {
                const int t = std::countr_zero(left);
                counts.add(ranges.first[t], ranges.last[t]);
                crossed.add(ranges.first[t], ranges.last[t]);
            }
            return crossed;
        };
        count_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_, count_block);
    });
}

std::size_t SoupSource::scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                bool origins) {
    const SoupScan scan(mesh_, placing_, unit_mm_, planes_, instructions_);
    return with_reader(mesh_, placing_, unit_mm_, [&](const auto& read) {
        const auto scatter_block = [&](std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
            if (scan.usable() && begin + block_triangles <= mesh_.triangle_count) {
                scan.write(begin, crossed, to);
            } else {
                scatter_each(read, planes_, begin, crossed, to);
            }
        };
        return scatter_blocks({mesh_.triangle_count, parallel_}, parallel_, buckets_, tier, reach_end, reaching, origins,
                              scatter_block);
    });
}

}  // namespace lamella
