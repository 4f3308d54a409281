// Sorting on several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/distribute.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"

namespace lamella {

/// As std::sort, in four calls of run(): items are distributed to parts, which are sorted one by one and written back.
/// Samples of the items tell where the parts end. `less` must tell any two items apart, or equal ones may change places from
/// call to call where it cannot be seen. As many bytes again as the items have. Throws std::bad_alloc.
template <class T, class Less>
void sort_in_parallel(std::span<T> items, Less less, const Parallel& parallel, const Memory* memory = nullptr) {
    constexpr std::size_t wanted = std::size_t{1} << 14;  // stays in the cache
    constexpr std::size_t samples_a_part = 32;
    if (items.size() <= wanted) {
        sort_briefly(items.begin(), items.end(), less);
        return;
    }
    const std::size_t count = parts_for(items.size(), wanted);
    std::vector<T> samples(count * samples_a_part);
    for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i] = items[items.size() * i / samples.size()];
    }
    sort_briefly(samples.begin(), samples.end(), less);
    std::vector<T> cuts(count - 1);
    for (std::size_t part = 1; part < count; ++part) {
        cuts[part - 1] = samples[part * samples_a_part];
    }
    // Equal items get one part, and smaller ones no later one. A search without branches, which no predictor would know.
    const auto part_of = [&](const T& item) {
        std::size_t at = 0;
        for (std::size_t left = cuts.size(); left > 0;) {
            const std::size_t half = (left + 1) / 2;
            at += less(item, cuts[at + half - 1]) ? 0 : half;
            left -= half;
        }
        return at;
    };
    Distributed<T> parts = distribute<T>(
        items.size(), count, parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t i = begin; i != end; ++i) {
                emit(part_of(items[i]), items[i]);
            }
        },
        memory);
    parallel.run(parts.size(), [&](std::size_t part, int) {
        const std::span<T> own = parts.of(part);
        sort_briefly(own.begin(), own.end(), less);
        std::copy(own.begin(), own.end(), items.begin() + static_cast<std::ptrdiff_t>(parts.firsts[part]));
    });
}

}  // namespace lamella
