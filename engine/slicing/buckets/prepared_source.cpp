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

/// A triangle that is not degenerate, as count_each() and write_each() read it.
struct PreparedTriangle {
    const CrossedTriangle* from;
    const PlaneSet* all_planes;

    static bool is_degenerate() noexcept { return false; }
    PlaneRange planes() const noexcept { return all_planes->between(from->lower.z, from->upper.z); }
    std::uint8_t write(CrossedTriangle& to, PlaneIndex last) const noexcept {
        to = *from;
        to.middle_and_source = from->middle_and_source | all_planes->first_above(from->middle.z);
        to.last = last;
        return static_cast<std::uint8_t>(from->last);
    }
};

/// Gives triangle t.
auto triangles_of(const detail::PreparedImpl& prepared, const PlaneSet& planes) noexcept {
    return [&prepared, &planes](std::size_t t) { return PreparedTriangle{&prepared.triangles[t], &planes}; };
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
    const auto is_cut = [this](Range range) { return planes_.any_between(range.low, range.high); };
    std::size_t count = 0;
    for (std::size_t super_block = 0; super_block < prepared_.super_blocks.size(); ++super_block) {
        if (super_block % super_blocks_between_stops == 0) {
            parallel_.stop_if_asked();
        }
        if (!is_cut(prepared_.super_blocks[super_block])) {
            continue;
        }
        const std::size_t end = std::min((super_block + 1) * group, prepared_.blocks.size());
        for (std::size_t block = super_block * group; block < end; ++block) {
            touched[count] = static_cast<std::uint32_t>(block);
            count += is_cut(prepared_.blocks[block]) ? 1U : 0U;
        }
    }
    touched.set_size(count);
}

/// Blocks are numbered among those touched: each has 64 triangles but the mesh's last.
void PreparedSource::count(double /*unit_mm*/) {
    find_touched();
    const auto count_block = [&, read = triangles_of(prepared_, planes_)](std::size_t begin, std::size_t,
                                                                          ShareCounts& counts) {
        const std::size_t first = first_of_touched(begin);
        return count_each(read, first, std::min(first + block_triangles, prepared_.triangles.size()), false, counts);
    };
    count_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, planes_.size(), buckets_, count_block);
    buckets_.degenerate = prepared_.given - prepared_.triangles.size();
}

std::size_t PreparedSource::scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                    bool origins) {
    const auto scatter_block = [&, read = triangles_of(prepared_, planes_)](std::size_t begin, std::uint64_t crossed,
                                                                            ShareRecords& to) {
        to.write_each(read, first_of_touched(begin), crossed);
    };
    return scatter_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, buckets_, tier, reach_end,
                          reaching, origins, scatter_block);
}

}  // namespace lamella
