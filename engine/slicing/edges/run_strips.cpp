#include "slicing/edges/run_strips.hpp"

#include <algorithm>
#include <bit>
#include <functional>

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

void RunStrips::assign(std::span<const EdgeRun> runs, std::int32_t margin) {
    runs_ = runs;
    margin_ = margin;
    firsts_.clear();
    if (runs.empty()) {
        return;
    }
    order_few();
    choose_strips();
    if (count() == 1) {
        firsts_[1] = runs.size();
        make_entries(runs.size());
        worker_.in_stretches(0, runs.size(), run_work, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                write_entry(i, static_cast<std::uint32_t>(order_[i]));
            }
        });
        return;
    }
    const auto for_each_entry = [&](const auto& work) {
        worker_.in_stretches(0, runs.size(), run_work,
                             [&](std::size_t begin, std::size_t end) { each_entry(begin, end, cursors_.data(), work); });
    };
    cursors_.assign(count(), 0);
    for_each_entry([](std::size_t, std::uint32_t) {});
    make_entries(count_to_cursors(1));
    for_each_entry([&](std::size_t at, std::uint32_t run) { write_entry(at, run); });
}

void RunStrips::assign(std::span<const EdgeRun> runs, std::int32_t margin, const Parallel& parallel) {
    if (runs.size() <= few_runs) {
        assign(runs, margin);
        return;
    }
    runs_ = runs;
    margin_ = margin;
    order_.resize(runs.size());
    parallel.run_ranges(runs.size(), runs_of_range, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t r = begin; r < end; ++r) {
            order_[r] = key_of(r);
        }
    });
    sort_in_parallel(std::span<std::uint64_t>(order_), std::less<>(), parallel);
    choose_strips();
    const std::size_t ranges = std::clamp<std::size_t>(runs.size() / runs_of_range, 1, most_ranges);
    const auto for_each_entry = [&](const auto& work) {
        parallel.run(ranges, [&](std::size_t range, int) {
            each_entry(runs.size() * range / ranges, runs.size() * (range + 1) / ranges, cursors_.data() + range * count(),
                       work);
        });
    };
    cursors_.assign(ranges * count(), 0);
    for_each_entry([](std::size_t, std::uint32_t) {});
    make_entries(count_to_cursors(ranges));
    for_each_entry([&](std::size_t at, std::uint32_t run) { write_entry(at, run); });
}

std::uint64_t RunStrips::key_of(std::size_t run) const noexcept {
    const std::uint32_t low_y = static_cast<std::uint32_t>(runs_[run].box.low.y) ^ 0x80000000U;
    return std::uint64_t{low_y} << 32 | run;
}

void RunStrips::order_few() {
    constexpr std::size_t very_few = 16;
    order_.resize(runs_.size());
    if (runs_.size() <= very_few) {
        for (std::size_t r = 0; r < runs_.size(); ++r) {
            order_[r] = key_of(r);
        }
    } else {
        spread_keys();
    }
    insert_in_order();
}

/// Into about as many buckets as there are runs, which leaves them nearly in order.
void RunStrips::spread_keys() {
    unordered_.resize(runs_.size());
    std::uint64_t lowest = key_of(0);
    std::uint64_t highest = lowest;
    for (std::size_t r = 0; r < runs_.size(); ++r) {
        const std::uint64_t key = key_of(r);
        unordered_[r] = key;
        lowest = std::min(lowest, key);
        highest = std::max(highest, key);
    }
    const int shift =
        std::max(0, static_cast<int>(std::bit_width(highest - lowest)) - static_cast<int>(std::bit_width(runs_.size())));
    const auto bucket_of = [&](std::uint64_t key) { return static_cast<std::size_t>((key - lowest) >> shift); };
    places_.assign(bucket_of(highest) + 1, 0);
    for (const std::uint64_t key : unordered_) {
        ++places_[bucket_of(key)];
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& place : places_) {
        const std::uint32_t count = place;
        place = sum;
        sum += count;
    }
    for (const std::uint64_t key : unordered_) {
        order_[places_[bucket_of(key)]++] = key;
    }
    worker_.spend(run_work * runs_.size());
}

/// Insertion sort; falls back to std::sort where the keys are not nearly in order.
void RunStrips::insert_in_order() {
    std::size_t patience = 16 * order_.size();
    for (std::size_t i = 1; i < order_.size(); ++i) {
        const std::uint64_t key = order_[i];
        std::size_t place = i;
        for (; place > 0 && key < order_[place - 1] && patience > 0; --place, --patience) {
            order_[place] = order_[place - 1];
        }
        order_[place] = key;
        if (patience == 0) {
            std::sort(order_.begin(), order_.end(), [this](std::uint64_t a, std::uint64_t b) {
                worker_.spend(1);
                return a < b;
            });
            return;
        }
    }
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
    const auto first_y = static_cast<std::int64_t>(order_.front() >> 32);
    const auto last_y = static_cast<std::int64_t>(order_.back() >> 32);
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
        const auto run = static_cast<std::uint32_t>(order_[i]);
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
