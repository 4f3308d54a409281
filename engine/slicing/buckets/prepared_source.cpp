#include "slicing/buckets/prepared_source.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/distribute.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

using Range = detail::PreparedImpl::Range;

constexpr std::size_t group = 64;

/// Which cell a triangle belongs to: numbered level by level, from the lowest cell of the lowest level up.
class Cells {
public:
    Cells(std::int32_t lowest, std::int32_t highest, std::size_t triangles) : lowest_(lowest) {
        constexpr std::size_t triangles_a_cell = 256;
        const std::uint64_t span = height(lowest, highest);
        constexpr std::size_t most_cells = 2048;  // of a level: counters of more would take 20 ms to clear
        const std::size_t wanted = std::min(parts_for(triangles, triangles_a_cell), most_cells);
        while ((span >> least_shift_) + 1 > wanted) {
            ++least_shift_;
        }
        for (int shift = least_shift_; shift <= static_cast<int>(std::bit_width(span)); ++shift) {
            first_[shift] = count_;
            count_ += static_cast<std::size_t>(span >> shift) + 1;
        }
    }

    std::size_t count() const noexcept { return count_; }
    std::size_t cell_of(std::int32_t low, std::int32_t high) const noexcept {
        const int shift = std::max(least_shift_, static_cast<int>(std::bit_width(height(low, high))));
        return first_[shift] + (height(lowest_, low) >> shift);
    }

private:
    static std::uint32_t height(std::int32_t low, std::int32_t high) noexcept {
        return static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low);
    }

    std::int32_t lowest_;
    int least_shift_ = 0;
    std::size_t first_[33] = {};  // cell of each level
    std::size_t count_ = 0;
};

template <class Item, class RangeOf>
void join_ranges(const Array<Item>& items, const Parallel& parallel, Array<Range>& ranges, RangeOf range_of) {
    constexpr std::size_t ranges_a_task = 256;
    ranges.resize_discarding((items.size() + group - 1) / group);
    parallel.run_ranges(ranges.size(), ranges_a_task, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t r = begin; r < end; ++r) {
            Range all{std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()};
            for (std::size_t i = r * group; i < std::min((r + 1) * group, items.size()); ++i) {
                const Range own = range_of(items[i]);
                all = {std::min(all.low, own.low), std::max(all.high, own.high)};
            }
            ranges[r] = all;
        }
    });
}

bool is_cut(Range range, const PlaneSet& planes) noexcept {
    return planes.z(planes.first_above(range.low)) < range.high;
}

}  // namespace

void detail::PreparedImpl::build(const MeshView& mesh, const Parallel& parallel) {
    const double unit_mm = frame.unit.mm;
    const Cells cells(to_even_grid(bounds.min_mm[2], unit_mm), to_even_grid(bounds.max_mm[2], unit_mm), mesh.triangle_count);
    with_reader(mesh, placing_of(mesh, asked), unit_mm, [&](const auto& read) {
        const auto emit_all = [&](std::size_t begin, std::size_t end, auto emit) {
            for (std::size_t t = begin; t < end; ++t) {
                const GridTriangle v = read(t);
                if (!is_degenerate(v)) {
                    CrossedTriangle ordered = order_by_height(v, static_cast<std::uint32_t>(t));
                    ordered.last = height_order_of(v).lower;
                    emit(cells.cell_of(ordered.lower.z, ordered.upper.z), ordered);
                }
            }
        };
        triangles = std::move(
            distribute<CrossedTriangle>(mesh.triangle_count, cells.count(), parallel, emit_all, triangles.memory()).items);
    });
    given = mesh.triangle_count;
    join_ranges(triangles, parallel, blocks, [](const CrossedTriangle& t) { return Range{t.lower.z, t.upper.z}; });
    join_ranges(blocks, parallel, super_blocks, [](const Range& range) { return range; });
}

std::size_t detail::PreparedImpl::bytes() const noexcept {
    return sizeof(*this) + triangles.capacity() * sizeof(CrossedTriangle) +
           (blocks.capacity() + super_blocks.capacity()) * sizeof(Range);
}

/// The blocks that a plane passes through, ascending.
void PreparedSource::find_touched() {
    constexpr std::size_t super_blocks_between_stops = 1024;
    Array<std::uint32_t>& touched = buckets_.touched;
    touched.resize_discarding(prepared_.blocks.size());
    std::size_t count = 0;
    for (std::size_t super_block = 0; super_block < prepared_.super_blocks.size(); ++super_block) {
        if (super_block % super_blocks_between_stops == 0) {
            parallel_.stop_if_asked();
        }
        if (!is_cut(prepared_.super_blocks[super_block], planes_)) {
            continue;
        }
        const std::size_t end = std::min((super_block + 1) * group, prepared_.blocks.size());
        for (std::size_t block = super_block * group; block < end; ++block) {
            touched[count] = static_cast<std::uint32_t>(block);
            count += is_cut(prepared_.blocks[block], planes_) ? 1 : 0;
        }
    }
    touched.set_size(count);
}

/// Blocks are numbered among those touched: each has 64 triangles but the mesh's last.
void PreparedSource::count(double /*unit_mm*/) {
    find_touched();
    const PlaneSet& planes = planes_;
    const auto count_block = [&](std::size_t begin, std::size_t, ShareCounts& counts) {
        const std::size_t first = std::size_t{buckets_.touched[begin / block_triangles]} * block_triangles;
        const std::size_t end = std::min(first + block_triangles, prepared_.triangles.size());
        std::uint64_t mask = 0;
        for (std::size_t i = first; i < end; ++i) {
            const CrossedTriangle& t = prepared_.triangles[i];
            const PlaneIndex plane = planes.first_above(t.lower.z);
            if (planes.z(plane) < t.upper.z) {
                counts.add(plane, planes.first_above(t.upper.z));
                mask |= std::uint64_t{1} << (i - first);
            }
        }
        return mask;
    };
    count_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, planes.size(), buckets_, count_block);
    buckets_.degenerate = prepared_.given - prepared_.triangles.size();
}

std::size_t PreparedSource::scatter(std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching, bool origins) {
    const PlaneSet& planes = planes_;
    buckets_.lowest_corners.resize_discarding(origins ? buckets_.list_begin[planes.size()] : 0);
    const auto scatter_block = [&](std::size_t begin, std::uint64_t mask, std::uint32_t* next_record,
                                   ReachingWriter& writer) {
        const std::size_t block = buckets_.touched[begin / block_triangles];
        const CrossedTriangle* const first_of_block = prepared_.triangles.data() + block * block_triangles;
        // First where records go, then the records: a store that waits for memory would hold up the next ones, and loads
        // that are a multiple of 4096 bytes away from it.
        Reaching places[block_triangles];
        std::size_t count = 0;
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const CrossedTriangle& t = first_of_block[std::countr_zero(crossed)];
            const PlaneIndex first = planes.first_above(t.lower.z);
            const std::uint32_t at = next_record[first]++;
            __builtin_prefetch(buckets_.records.data() + at, 1);
            places[count++] = {at, first, planes.first_above(t.upper.z)};
        }
        std::size_t next = 0;
        for (std::uint64_t crossed = mask; crossed != 0; crossed &= crossed - 1) {
            const Reaching place = places[next++];
            const CrossedTriangle& from = first_of_block[std::countr_zero(crossed)];
            CrossedTriangle& to = buckets_.records[place.record];
            if (origins) {
                buckets_.lowest_corners[place.record] = static_cast<std::uint8_t>(from.last);
            }
            to = from;
            to.middle_and_source = from.middle_and_source | planes.first_above(from.middle.z);
            to.last = place.last;
            if (place.last > reach_end[place.first]) {
                writer.add(place);
            }
        }
    };
    return scatter_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, planes.size(), buckets_,
                          reaching, scatter_block);
}

}  // namespace lamella
