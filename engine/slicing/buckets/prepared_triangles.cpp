#include "slicing/buckets/prepared_triangles.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/distribute.hpp"
#include "slicing/buckets/bucket_parts.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

using Range = PreparedTriangles::Range;

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

/// The blocks that a plane passes through, ascending.
void find_touched(const PreparedTriangles& prepared, const PlaneSet& planes, const Parallel& parallel,
                  Array<std::uint32_t>& touched) {
    constexpr std::size_t super_blocks_between_stops = 1024;
    touched.resize_discarding(prepared.blocks.size());
    std::size_t count = 0;
    for (std::size_t super_block = 0; super_block < prepared.super_blocks.size(); ++super_block) {
        if (super_block % super_blocks_between_stops == 0) {
            parallel.stop_if_asked();
        }
        if (!is_cut(prepared.super_blocks[super_block], planes)) {
            continue;
        }
        const std::size_t end = std::min((super_block + 1) * group, prepared.blocks.size());
        for (std::size_t block = super_block * group; block < end; ++block) {
            touched[count] = static_cast<std::uint32_t>(block);
            count += is_cut(prepared.blocks[block], planes) ? 1 : 0;
        }
    }
    touched.set_size(count);
}

/// Calls use(triangle, its bit) for each of a block.
template <class Use>
void for_each_of(const PreparedTriangles& prepared, std::size_t block, Use use) {
    const std::size_t begin = block * block_triangles;
    const std::size_t end = std::min(begin + block_triangles, prepared.triangles.size());
    for (std::size_t t = begin; t < end; ++t) {
        use(prepared.triangles[t], std::uint64_t{1} << (t - begin));
    }
}

/// Calls use(part, number among those touched, block) for each block that planes touch: parts by different threads.
template <class Use>
void for_each_touched(const Buckets& buckets, const BucketParts& parts, const Parallel& parallel, Use use) {
    parallel.run(parts.count, [&](std::size_t part, int) {
        for (std::size_t i = parts.begin_block(part); i < parts.begin_block(part + 1); ++i) {
            if (i % blocks_between_stops == 0) {
                parallel.stop_if_asked();
            }
            use(part, i, std::size_t{buckets.touched[i]});
        }
    });
}

}  // namespace

std::size_t PreparedTriangles::bytes() const noexcept {
    return triangles.capacity() * sizeof(CrossedTriangle) + (blocks.capacity() + super_blocks.capacity()) * sizeof(Range);
}

void PreparedTriangles::build(const MeshView& mesh, const Transform& transform, const Bounds& bounds, double unit_mm,
                              const Parallel& parallel) {
    const Cells cells(to_even_grid(bounds.min_mm[2], unit_mm), to_even_grid(bounds.max_mm[2], unit_mm), mesh.triangle_count);
    with_reader(mesh, transform, unit_mm, [&](const auto& read) {
        triangles = std::move(distribute<CrossedTriangle>(
                                  mesh.triangle_count, cells.count(), parallel,
                                  [&](std::size_t begin, std::size_t end, auto emit) {
                                      for (std::size_t t = begin; t < end; ++t) {
                                          const GridTriangle v = read(t);
                                          if (!is_degenerate(v)) {
                                              CrossedTriangle ordered = order_by_height(v, static_cast<std::uint32_t>(t));
                                              ordered.last = height_order_of(v).lower;
                                              emit(cells.cell_of(ordered.lower.z, ordered.upper.z), ordered);
                                          }
                                      }
                                  },
                                  triangles.memory())
                                  .items);
    });
    degenerate = mesh.triangle_count - triangles.size();
    join_ranges(triangles, parallel, blocks, [](const CrossedTriangle& t) { return Range{t.lower.z, t.upper.z}; });
    join_ranges(blocks, parallel, super_blocks, [](const Range& range) { return range; });
}

void count_crossings(const PreparedTriangles& prepared, const PlaneSet& planes, const Parallel& parallel, Buckets& buckets) {
    find_touched(prepared, planes, parallel, buckets.touched);
    const BucketParts parts(buckets.touched.size() * block_triangles, parallel);
    const std::size_t k = planes.size();
    buckets.crossed_mask.resize_discarding(buckets.touched.size());
    make_counters(planes, parts.count, buckets);
    std::fill(buckets.counters.begin(), buckets.counters.end(), 0U);
    for_each_touched(buckets, parts, parallel, [&](std::size_t part, std::size_t i, std::size_t block) {
        const PartCounts counts(buckets, part, k);
        std::uint64_t mask = 0;
        for_each_of(prepared, block, [&](const CrossedTriangle& t, std::uint64_t bit) {
            const PlaneIndex first = planes.first_above(t.lower.z);
            if (planes.z(first) < t.upper.z) {
                ++counts.starting[first];
                ++counts.ended[planes.first_above(t.upper.z)];
                mask |= bit;
            }
        });
        buckets.crossed_mask[i] = mask;
    });
    buckets.degenerate = prepared.degenerate;
    sum_up(planes, parts.count, buckets);
}

std::size_t scatter_triangles(const PreparedTriangles& prepared, const PlaneSet& planes,
                              std::span<const PlaneIndex> reach_end, const Parallel& parallel, Buckets& buckets,
                              std::span<Reaching> reaching, bool origins) {
    const BucketParts parts(buckets.touched.size() * block_triangles, parallel);
    buckets.records.resize_discarding(buckets.list_begin[planes.size()]);
    buckets.lowest_corners.resize_discarding(origins ? buckets.records.size() : 0);
    ReachingOutput output(reaching, parts.count);
    for_each_touched(buckets, parts, parallel, [&](std::size_t part, std::size_t i, std::size_t block) {
        const PartCursors cursors(buckets, part, planes.size());
        const CrossedTriangle* const first_of_block = prepared.triangles.data() + block * block_triangles;
        // First where records go, then the records: a store that waits for memory would hold up the next ones, and loads
        // that are a multiple of 4096 bytes away from it.
        Reaching places[block_triangles];
        std::size_t count = 0;
        for (std::uint64_t crossed = buckets.crossed_mask[i]; crossed != 0; crossed &= crossed - 1) {
            const CrossedTriangle& t = first_of_block[std::countr_zero(crossed)];
            const PlaneIndex first = planes.first_above(t.lower.z);
            const std::uint32_t at = cursors.next_record[first]++;
            __builtin_prefetch(buckets.records.data() + at, 1);
            places[count++] = {at, first, planes.first_above(t.upper.z)};
        }
        std::size_t next = 0;
        for (std::uint64_t crossed = buckets.crossed_mask[i]; crossed != 0; crossed &= crossed - 1) {
            const Reaching place = places[next++];
            const CrossedTriangle& from = first_of_block[std::countr_zero(crossed)];
            CrossedTriangle& to = buckets.records[place.record];
            if (origins) {
                buckets.lowest_corners[place.record] = static_cast<std::uint8_t>(from.last);
            }
            to = from;
            to.middle_and_source = from.middle_and_source | planes.first_above(from.middle.z);
            to.last = place.last;
            if (place.last > reach_end[place.first]) {
                output.add(part, place);
            }
        }
    });
    return output.finish();
}

}  // namespace lamella
