// Sorting on several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "base/parallel.hpp"

namespace lamella {

/// Eight parts are sorted, then merged pairwise. `less` must tell any two items apart, or equal ones may change places from
/// call to call where it cannot be seen.
template <class T, class Less>
void sort_in_parallel(std::span<T> items, Less less, const Parallel& parallel) {
    constexpr std::size_t parts = 8;
    const auto part = [&](std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(items.size() * i / parts); };
    parallel.run(parts, [&](std::size_t i, int) { std::sort(part(i), part(i + 1), less); });
    for (std::size_t width = 1; width < parts; width *= 2) {
        parallel.run(parts / (2 * width), [&](std::size_t i, int) {
            const std::size_t first = 2 * width * i;
            std::inplace_merge(part(first), part(first + width), part(first + 2 * width), less);
        });
    }
}

}  // namespace lamella
