#include <algorithm>
#include <bit>

#include "base/guard.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/thread_shares.hpp"

namespace lamella {

namespace {

/// A triangle on the grid, as count_each() and write_each() read it.
struct SoupTriangle {
    GridTriangle v;
    const PlaneSet* all_planes;
    std::size_t number;

    bool is_degenerate() const noexcept { return lamella::is_degenerate(v); }
    PlaneRange planes() const noexcept {
        const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
        return all_planes->between(low, high);
    }
    std::uint8_t write(CrossedTriangle& to, PlaneIndex last) const noexcept {
        to = order_by_height(v, static_cast<std::uint32_t>(number));
        to.middle_and_source |= all_planes->first_above(to.middle.z);
        to.last = last;
        return height_order_of(v).lower;
    }
};

/// Gives triangle t.
template <class Read>
auto triangles_of(const Read& read, const PlaneSet& planes) noexcept {
    return [&read, &planes](std::size_t t) { return SoupTriangle{read(t), &planes, t}; };
}

}  // namespace

Bounds SoupSource::measure(double asked_mm) {
    return require(measure_bounds(mesh_, placing_, asked_mm, parallel_, buckets_.blocks));
}

void SoupSource::count(double unit_mm) {
    unit_mm_ = unit_mm;
    const SoupScan scan(mesh_, placing_, unit_mm, planes_);
    with_reader(mesh_, placing_, unit_mm, [&](const auto& read) {
        const auto count_block = [&](std::size_t begin, std::size_t end, ShareCounts& counts) -> std::uint64_t {
            const std::size_t block = begin / block_triangles;
            const bool may_be_degenerate = buckets_.blocks.may_be_degenerate(block, unit_mm);
            const bool skipped = !may_be_degenerate && lies_between_planes(buckets_.blocks.blocks[block], unit_mm, planes_);
            if (skipped) {
                return 0;
            }
            if (!scan.usable() || end - begin < block_triangles || may_be_degenerate) {
                return count_each(triangles_of(read, planes_), begin, end, may_be_degenerate, counts);
            }
            SoupScan::Ranges ranges;
            const std::uint64_t mask = scan.ranges(begin, ranges);
            for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
                const int t = std::countr_zero(crossed);
                counts.add(ranges.first[t], ranges.last[t]);
            }
            return mask;
        };
        count_blocks({mesh_.triangle_count, parallel_}, parallel_, planes_.size(), buckets_, count_block);
    });
}

std::size_t SoupSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) {
    const SoupScan scan(mesh_, placing_, unit_mm_, planes_);
    return with_reader(mesh_, placing_, unit_mm_, [&](const auto& read) {
        const auto scatter_block = [&](std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
            if (scan.usable() && begin + block_triangles <= mesh_.triangle_count) {
                scan.write(begin, crossed, to);
            } else {
                to.write_each(triangles_of(read, planes_), begin, crossed);
            }
        };
        return scatter_blocks({mesh_.triangle_count, parallel_}, parallel_, buckets_, reach_end, reaching, origins,
                              scatter_block);
    });
}

}  // namespace lamella
