#include <bit>

#include "base/guard.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

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

/// Gives triangle t.
template <class Reader>
auto triangles_of(const Reader& read, const PlaneSet& planes) noexcept {
    return [&](std::size_t t) { return RoundedTriangle{read(t), t, planes}; };
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
                return count_each(triangles_of(read, planes_), begin, end, may_be_degenerate, counts);
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
                to.write_each_once(triangles_of(read, planes_), begin, crossed);
            }
        };
        return scatter_blocks({mesh_.triangle_count, parallel_}, parallel_, buckets_, tier, reach_end, reaching, origins,
                              scatter_block);
    });
}

}  // namespace lamella
