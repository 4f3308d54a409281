#include "slicing/buckets/prepared_source.hpp"

#include <algorithm>
#include <bit>

#include "base/distribute.hpp"
#include "base/guard.hpp"
#include "slicing/buckets/thread_shares.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

namespace {

using Range = detail::PreparedImpl::Range;

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

/// A triangle of the order, as count_each() reads it.
struct PreparedTriangle {
    const detail::PreparedImpl::Triangle& own;
    const PlaneSet& all_planes;

    static bool is_degenerate() noexcept { return false; }
    PlaneRange planes() const noexcept { return all_planes.between(own.range.low, own.range.high); }
};

}  // namespace

void detail::PreparedImpl::build(const Parallel& parallel) {
    constexpr std::size_t block_grain = 64;
    const double unit_mm = frame.unit.mm;
    const Cells cells(to_even_grid(bounds.min_mm[2], unit_mm), to_even_grid(bounds.max_mm[2], unit_mm), mesh.triangle_count);
    with_reader(mesh, placing_of(mesh, asked), unit_mm, [&](const auto& read) {
        const auto emit_all = [&](std::size_t begin, std::size_t end, auto emit) {
            for (std::size_t t = begin; t < end; ++t) {
                const GridTriangle v = read(t);
                if (!is_degenerate(v)) {
                    const auto [low, high] = std::minmax({v[0].z, v[1].z, v[2].z});
                    emit(cells.cell_of(low, high), Triangle{static_cast<std::uint32_t>(t), {low, high}});
                }
            }
        };
        order =
            std::move(distribute<Triangle>(mesh.triangle_count, cells.count(), parallel, emit_all, order.memory()).items);
    });
    blocks.resize_discarding((order.size() + block_triangles - 1) / block_triangles);
    parallel.run_ranges(blocks.size(), block_grain, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin * block_triangles; i < std::min(end * block_triangles, order.size()); ++i) {
            const Range own = order[i].range;
            Range& all = blocks[i / block_triangles];
            all = i % block_triangles == 0 ? own : Range{std::min(all.low, own.low), std::max(all.high, own.high)};
        }
    });
}

std::size_t detail::PreparedImpl::bytes() const noexcept {
    return sizeof(*this) + order.capacity() * sizeof(Triangle) + blocks.capacity() * sizeof(Range);
}

const Frame& detail::PreparedImpl::frame_for(const Frame& given) const {
    const auto refuse = [](const char* why) { throw Refused{{ErrorCode::invalid_argument, why}}; };
    if (given.grid_mm != 0 && given.grid_mm != asked_grid_mm && given.grid_mm != asked.grid_mm) {
        refuse("the mesh was prepared on another grid than the one asked for");
    }
    if (!given.transform.is_identity() && !(given.transform == asked.transform)) {
        refuse("the mesh was prepared with another transform than the one asked for");
    }
    if (given.as_mesh_numbers && !asked.as_mesh_numbers) {
        refuse("the mesh was prepared in double, not as its own numbers");
    }
    return asked;
}

/// The blocks that a plane passes through, ascending.
void PreparedSource::find_touched() {
    constexpr std::size_t blocks_between_stops = std::size_t{1} << 16;
    Array<std::uint32_t>& touched = buckets_.touched;
    touched.resize_discarding(prepared_.blocks.size());
    std::size_t count = 0;
    for (std::size_t block = 0; block < prepared_.blocks.size(); ++block) {
        if (block % blocks_between_stops == 0) {
            parallel_.stop_if_asked();
        }
        touched[count] = static_cast<std::uint32_t>(block);
        count += planes_.any_between(prepared_.blocks[block].low, prepared_.blocks[block].high) ? 1U : 0U;
    }
    touched.set_size(count);
}

/// Blocks are numbered among those touched: each has 64 triangles but the mesh's last. Where most are, the mesh is read as
/// it lies.
void PreparedSource::count(double unit_mm) {
    find_touched();
    const MeshView& mesh = prepared_.mesh;
    whole_ = nullptr;
    if (2 * buckets_.touched.size() > prepared_.blocks.size()) {
        whole_ = &source_of(mesh, placing_, info.frame, {parallel_, planes_, buckets_, instructions_}, any_whole_);
        whole_->measure(unit_mm);
        return whole_->count(unit_mm);
    }
    const auto count_block = [&](std::size_t begin, std::size_t, ShareCounts& counts) {
        const std::size_t first = first_of_touched(begin);
        const auto triangle = [this](std::size_t place) { return PreparedTriangle{prepared_.order[place], planes_}; };
        return count_each(triangle, first, std::min(first + block_triangles, prepared_.order.size()), false, counts);
    };
    count_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, planes_.size(), buckets_, count_block);
    buckets_.degenerate = mesh.triangle_count - prepared_.order.size();
}

std::size_t PreparedSource::scatter(PlaneRange tier, std::span<const PlaneIndex> reach_end, std::span<Reaching> reaching,
                                    bool origins) {
    if (whole_ != nullptr) {
        return whole_->scatter(tier, reach_end, reaching, origins);
    }
    return with_reader(prepared_.mesh, placing_, prepared_.frame.unit.mm, [&](const auto& read) {
        const auto triangle = [&](std::size_t place) {
            const std::uint32_t number = prepared_.order[place].number;
            return RoundedTriangle{read(number), number, planes_};
        };
        const auto scatter_block = [&](std::size_t begin, std::uint64_t crossed, ShareRecords& to) {
            to.write_each_once(triangle, first_of_touched(begin), crossed);
        };
        return scatter_blocks({buckets_.touched.size() * block_triangles, parallel_}, parallel_, buckets_, tier, reach_end,
                              reaching, origins, scatter_block);
    });
}

}  // namespace lamella
