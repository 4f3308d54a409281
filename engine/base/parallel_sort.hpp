// Sorting on several threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/distribute.hpp"
#include "base/parallel.hpp"

namespace lamella {

/// Values that cut an ascending order into parts of about as many items each, taken from samples.
template <class T, class Less>
class Splitters {
public:
    /// `sample(i)` gives one of `count` items. The answer depends on nothing but these.
    template <class Sample>
    Splitters(std::size_t count, std::size_t parts, Less less, Sample sample) : less_(less) {
        constexpr std::size_t samples_a_part = 32;
        std::vector<T> samples;
        const std::size_t wanted = std::min(count, parts * samples_a_part);
        samples.reserve(wanted);
        for (std::size_t i = 0; i < wanted; ++i) {
            samples.push_back(sample(count * i / wanted));
        }
        std::sort(samples.begin(), samples.end(), less);
        for (std::size_t part = 1; part < parts && !samples.empty(); ++part) {
            cuts_.push_back(samples[samples.size() * part / parts]);
        }
    }

    std::size_t parts() const noexcept { return cuts_.size() + 1; }

    /// Equal items get one part, and smaller ones no later one.
    std::size_t part_of(const T& item) const noexcept {
        const T* base = cuts_.data();  // a search without branches, which no predictor would know
        std::size_t left = cuts_.size();
        std::size_t at = 0;
        while (left > 0) {
            const std::size_t half = (left + 1) / 2;
            at += less_(item, base[at + half - 1]) ? 0 : half;
            left -= half;
        }
        return at;
    }

private:
    std::vector<T> cuts_;
    Less less_;
};

/// As std::sort, in four calls of run(): items are distributed to parts, which are sorted one by one and written back.
/// `less` must tell any two items apart, or equal ones may change places from call to call where it cannot be seen. As many
/// bytes again as the items have. Throws std::bad_alloc.
template <class T, class Less>
void sort_in_parallel(std::span<T> items, Less less, const Parallel& parallel, const Memory* memory = nullptr) {
    constexpr std::size_t wanted = std::size_t{1} << 14;  // stays in the cache
    if (items.size() <= wanted) {
        std::sort(items.begin(), items.end(), less);
        return;
    }
    const Splitters<T, Less> splitters(items.size(), parts_for(items.size(), wanted), less,
                                       [&](std::size_t i) { return items[i]; });
    Distributed<T> parts = distribute<T>(
        items.size(), splitters.parts(), parallel,
        [&](std::size_t begin, std::size_t end, const auto& emit) {
            for (std::size_t i = begin; i != end; ++i) {
                emit(splitters.part_of(items[i]), items[i]);
            }
        },
        memory);
    parallel.run(parts.size(), [&](std::size_t part, int) {
        const std::span<T> own = parts.of(part);
        std::sort(own.begin(), own.end(), less);
        std::copy(own.begin(), own.end(), items.begin() + static_cast<std::ptrdiff_t>(parts.firsts[part]));
    });
}

}  // namespace lamella
