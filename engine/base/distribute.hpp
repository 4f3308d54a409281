// Items brought together by a number that each has: count, prefix sum, scatter. No locks, and the order does not depend on
// threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/vector.hpp"
#include "lamella/array.hpp"

namespace lamella {

/// Items in parts; within a part they keep the order in which they came. Its memory is kept from use to use.
template <class T>
class Distributed {
public:
    explicit Distributed(const Memory* memory) noexcept : items(memory) {}

    Array<T> items;
    Vector<std::size_t> firsts{items.memory()};   ///< by part, and the end of the last
    Vector<std::size_t> cursors{items.memory()};  ///< scratch of distribute(): first a count, then where the next item goes

    std::size_t size() const noexcept { return firsts.size() - 1; }
    std::span<T> of(std::size_t part) noexcept {
        return items.span().subspan(firsts[part], firsts[part + 1] - firsts[part]);
    }
};

/// Touches the pages of memory that is new, so that they are made in stretches between which a stop is noticed. Else the
/// first items that are scattered over it would make all of them: half a second for a gigabyte.
inline void touch_pages(std::byte* bytes, std::size_t count, const Parallel& parallel) {
    constexpr std::size_t stretch = std::size_t{1} << 22;
    constexpr std::size_t page = 4096;
    parallel.run(count / stretch, [&](std::size_t i, int) {
        for (std::size_t at = i * stretch; at < (i + 1) * stretch; at += page) {
            bytes[at] = std::byte{0};
        }
    });
}

/// Into how many ranges `count` items are cut of which each has an array of its own: of 2^16 items, or four for each thread
/// if that is more, but not of under 2^12.
inline std::size_t ranges_for(std::size_t count, const Parallel& parallel) noexcept {
    const std::size_t enough =
        std::max<std::size_t>(static_cast<std::size_t>(parallel.threads()) * 4, count / (std::size_t{1} << 16));
    return std::clamp<std::size_t>(count / 4096, 1, enough);
}

/// Three calls of run(). `each(begin, end, emit)` calls emit(part, item) for every item that comes from [begin, end), and
/// the same again when it is called again. Beside the items it takes 8 bytes a part for each 2^16 of `count`. Throws
/// std::bad_alloc.
template <class T, class Each>
void distribute(std::size_t count, std::size_t parts, const Parallel& parallel, Each each, Distributed<T>& sorted) {
    const std::size_t ranges = ranges_for(count, parallel);
    const auto first = [&](std::size_t range) { return count * range / ranges; };
    sorted.cursors.assign(ranges * parts, 0);
    parallel.run(ranges, [&](std::size_t range, int) {
        std::size_t* const own = sorted.cursors.data() + range * parts;
        each(first(range), first(range + 1), [&](std::size_t part, const T&) { ++own[part]; });
    });
    sorted.firsts.resize(parts + 1);
    std::size_t sum = 0;
    for (std::size_t part = 0; part < parts; ++part) {
        sorted.firsts[part] = sum;
        for (std::size_t range = 0; range < ranges; ++range) {
            sum += std::exchange(sorted.cursors[range * parts + part], sum);
        }
    }
    sorted.firsts[parts] = sum;
    const bool is_new = sum > sorted.items.capacity();
    sorted.items.resize_discarding(sum);
    T* const items = sorted.items.data();
    if (is_new) {
        touch_pages(reinterpret_cast<std::byte*>(items), sum * sizeof(T), parallel);
    }
    parallel.run(ranges, [&](std::size_t range, int) {
        std::size_t* const own = sorted.cursors.data() + range * parts;
        each(first(range), first(range + 1), [&](std::size_t part, const T& item) { items[own[part]++] = item; });
    });
}

/// The same, made anew in `memory`.
template <class T, class Each>
Distributed<T> distribute(std::size_t count, std::size_t parts, const Parallel& parallel, Each each,
                          const Memory* memory = nullptr) {
    Distributed<T> sorted(memory);
    distribute(count, parts, parallel, each, sorted);
    return sorted;
}

/// Two calls of run(): numbers the items under `count` for which is_counted(item) holds in ascending order. Calls room(how
/// many there are), and then see(item, number of the last one up to it, whether it is one) for all. Throws std::bad_alloc.
template <class IsCounted, class Room, class See>
void number_where(std::size_t count, const Parallel& parallel, const IsCounted& is_counted, const Room& room,
                  const See& see) {
    constexpr std::size_t range_size = std::size_t{1} << 13;
    constexpr std::size_t most_ranges = std::size_t{1} << 12;
    const std::size_t ranges = std::clamp<std::size_t>(count / range_size, 1, most_ranges);
    const auto first = [&](std::size_t range) { return count * range / ranges; };
    std::vector<std::uint32_t> firsts(ranges + 1, 0);  // how many a range has, then the first of them
    parallel.run(ranges, [&](std::size_t range, int) {
        std::uint32_t own = 0;
        for (std::size_t i = first(range); i != first(range + 1); ++i) {
            own += is_counted(i) ? 1U : 0U;
        }
        firsts[range] = own;
    });
    std::exclusive_scan(firsts.begin(), firsts.end(), firsts.begin(), 0U);
    room(firsts.back());
    parallel.run(ranges, [&](std::size_t range, int) {
        std::uint32_t next = firsts[range];
        for (std::size_t i = first(range); i != first(range + 1); ++i) {
            const bool counted = is_counted(i);
            next += counted ? 1U : 0U;
            see(i, next - 1, counted);
        }
    });
}

/// The same two calls: the indices under `count` for which test(index) holds, ascending. Throws std::bad_alloc.
template <class Test>
Array<std::uint32_t> indices_where(std::size_t count, const Parallel& parallel, const Memory* memory, const Test& test) {
    Array<std::uint32_t> found(memory);
    number_where(
        count, parallel, test, [&](std::size_t room) { found.resize_discarding(room); },
        [&](std::size_t i, std::uint32_t number, bool holds) {
            if (holds) {
                found[number] = static_cast<std::uint32_t>(i);
            }
        });
    return found;
}

/// Sorts the items of a part by a number that each has, where these lie close together, and then by `less`; its memory is
/// kept. O(items + range of numbers), and what std::sort takes for the items of each number.
template <class T>
class alignas(worker_alignment) PartSort {
public:
    template <class Number, class Less>
    void run(std::span<T> items, Number number_of, Less less) {
        if (items.empty()) {
            return;
        }
        const auto by_number = [&](const T& a, const T& b) { return number_of(a) < number_of(b); };
        const auto [first, last] = std::minmax_element(items.begin(), items.end(), by_number);
        const std::size_t low = number_of(*first);
        ends_.assign(number_of(*last) - low + 2, 0);
        for (const T& item : items) {
            ++ends_[number_of(item) - low + 1];
        }
        for (std::size_t i = 1; i < ends_.size(); ++i) {
            ends_[i] += ends_[i - 1];
        }
        unsorted_.assign(items.begin(), items.end());
        for (const T& item : unsorted_) {
            items[ends_[number_of(item) - low]++] = item;
        }
        std::size_t begin = 0;
        for (std::size_t i = 0; i + 1 < ends_.size(); ++i) {
            sort_briefly(items.begin() + static_cast<std::ptrdiff_t>(begin), items.begin() + ends_[i], less);
            begin = ends_[i];
        }
    }

private:
    std::vector<T> unsorted_;
    std::vector<std::uint32_t> ends_;  ///< by number: where its items end, once they are placed
};

/// How many parts of about `wanted` items make up `count`.
constexpr std::size_t parts_for(std::size_t count, std::size_t wanted) {
    constexpr std::size_t most_parts = std::size_t{1} << 12;
    return std::clamp<std::size_t>(count / wanted, 1, most_parts);
}

/// Part of `number`, which is under `end`, of `parts` that ascend with it.
inline std::size_t part_of_number(std::uint64_t number, std::uint64_t end, std::size_t parts) noexcept {
    return static_cast<std::size_t>(number * parts / end);
}

}  // namespace lamella
