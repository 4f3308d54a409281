#include "slicing/edges/run_strips.hpp"

#include <algorithm>

#include "base/parallel_sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t runs_of_range = std::size_t{1} << 15;
constexpr std::size_t most_ranges = 16;
constexpr std::size_t few_runs = std::size_t{1} << 16;  ///< are ordered on one thread
constexpr std::int64_t runs_of_strip = 8;
constexpr std::int64_t most_of_one_strip = 512;  ///< runs that need no strips where they are not side by side
constexpr std::int64_t most_abreast = 16;        ///< of these at one height, on average
constexpr std::size_t run_work = 8;              ///< as StopPace counts it

/// Leaves the contents unspecified; memory grows by half, so that layers of many sizes take it only a few times.
template <class T>
void make_room(Array<T>& array, std::size_t count) {
    if (count > array.capacity()) {
        array.resize_discarding(count + count / 2);
    }
    array.set_size(count);
}

}  // namespace

void RunStrips::assign(std::span<const EdgeRun> runs, std::int32_t margin, const Parallel* parallel) {
    runs_ = runs;
    margin_ = margin;
    firsts_.clear();
    if (runs.empty()) {
        return;
    }
    const bool alone = parallel == nullptr || runs.size() <= few_runs;
    const auto list = [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t r = begin; r < end; ++r) {
            order_[r] = key_of(r);
        }
    };
    order_.resize(runs.size());
    if (alone) {
        list(0, runs.size(), 0);
        nesting::sort_keys(order_, spare_, worker_);
    } else {
        parallel->run_ranges(runs.size(), runs_of_range, list);
        sort_in_parallel(std::span(order_), nesting::before, *parallel);
    }
    choose_strips();
    if (alone && count() == 1) {
        firsts_[1] = runs.size();
        make_entries(runs.size());
        worker_.in_stretches(0, runs.size(), run_work, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                write_entry(i, order_[i].index);
            }
        });
        return;
    }
    const std::size_t ranges = alone ? 1 : std::clamp<std::size_t>(runs.size() / runs_of_range, 1, most_ranges);
    const auto for_each_entry = [&](const auto& work) {
        if (alone) {
            worker_.in_stretches(0, runs.size(), run_work,
                                 [&](std::size_t begin, std::size_t end) { each_entry(begin, end, cursors_.data(), work); });
            return;
        }
        parallel->run(ranges, [&](std::size_t range, int) {
            each_entry(runs.size() * range / ranges, runs.size() * (range + 1) / ranges, cursors_.data() + range * count(),
                       work);
        });
    };
    cursors_.assign(ranges * count(), 0);
    for_each_entry([](std::size_t, std::uint32_t) {});
    make_entries(count_to_cursors(ranges));
    for_each_entry([&](std::size_t at, std::uint32_t run) { write_entry(at, run); });
}

/// By the lower side.
nesting::SortKey RunStrips::key_of(std::size_t run) const noexcept {
    return {static_cast<std::uint32_t>(runs_[run].box.low.y) ^ 0x80000000U, static_cast<std::uint32_t>(run)};
}

/// About twice as wide as runs are on average, so that few reach into many. One strip where few runs lie side by side.
void RunStrips::choose_strips() {
    std::int32_t low = runs_[0].box.low.x;
    std::int32_t high = runs_[0].box.high.x;
    std::int64_t widths = 0;
    std::int64_t heights = 0;
    for (const EdgeRun& run : runs_) {
        low = std::min(low, run.box.low.x);
        high = std::max(high, run.box.high.x);
        widths += width_of(run.box);
        heights += height_of(run.box);
    }
    const auto runs = static_cast<std::int64_t>(runs_.size());
    const auto first_y = static_cast<std::int64_t>(order_.front().key);
    const auto last_y = static_cast<std::int64_t>(order_.back().key);
    low_ = low;
    shift_ = 0;
    const std::int64_t all = std::int64_t{high} + margin_ - low;
    const bool in_one = runs <= most_of_one_strip && heights + runs * margin_ < most_abreast * (last_y - first_y);
    const std::int64_t most = in_one ? 0 : runs / runs_of_strip;
    const std::int64_t least_width = 2 * (widths + runs * margin_);
    while (((all >> shift_) > most || (std::int64_t{1} << shift_) * runs < least_width) && shift_ < 33) {
        ++shift_;
    }
    firsts_.assign(static_cast<std::size_t>(all >> shift_) + 2, 0);
}

/// Calls work(cursors[s]++, run) for each strip s that a run reaches into, of runs [begin, end) in order.
template <class Work>
void RunStrips::each_entry(std::size_t begin, std::size_t end, std::size_t* cursors, const Work& work) const {
    for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t run = order_[i].index;
        const FlatBox& box = runs_[run].box;
        const std::size_t last = strip_of(std::int64_t{box.high.x} + margin_);
        for (std::size_t s = strip_of(box.low.x); s <= last; ++s) {
            work(cursors[s]++, run);
        }
    }
}

/// Returns the number of all entries.
std::size_t RunStrips::count_to_cursors(std::size_t ranges) noexcept {
    std::size_t sum = 0;
    for (std::size_t s = 0; s < count(); ++s) {
        firsts_[s] = sum;
        for (std::size_t range = 0; range < ranges; ++range) {
            sum += std::exchange(cursors_[range * count() + s], sum);
        }
    }
    firsts_.back() = sum;
    return sum;
}

void RunStrips::make_entries(std::size_t count) {
    for (Array<std::int32_t>* numbers : {&low_x_, &low_y_, &high_x_, &high_y_}) {
        make_room(*numbers, count + run_lanes);
    }
    make_room(run_at_, count + run_lanes);
}

void RunStrips::write_entry(std::size_t at, std::uint32_t run) noexcept {
    const FlatBox& box = runs_[run].box;
    low_x_[at] = box.low.x;
    low_y_[at] = box.low.y;
    high_x_[at] = box.high.x + margin_;
    high_y_[at] = box.high.y + margin_;
    run_at_[at] = run;
}

std::size_t RunStrips::first_strip_of(std::size_t share, std::size_t shares) const noexcept {
    if (firsts_.empty()) {
        return 0;
    }
    const std::size_t entries = firsts_.back() * share / shares;
    return share == shares
               ? count()
               : static_cast<std::size_t>(std::lower_bound(firsts_.begin(), firsts_.end() - 1, entries) - firsts_.begin());
}

}  // namespace lamella
