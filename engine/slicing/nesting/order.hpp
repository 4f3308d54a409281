// Order of contours by their starts, and of anything else by a 64-bit key.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"

namespace lamella::nesting {

/// A key and the number of the element that it belongs to.
struct SortKey {
    std::uint64_t key = 0;
    std::uint32_t index = 0;
};

/// By key, then index.
constexpr bool before(const SortKey& a, const SortKey& b) noexcept {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
}

/// Orders as points do: by x, then y. This is the order of starts: layers are sorted by it, a parent therefore starts before
/// its children, and windows of starts reach to the right. RingFacts finds the start by the same order, and audit() and
/// canonical_order rely on it.
constexpr std::uint64_t key_of(Point point) noexcept {
    const auto biased = [](std::int32_t value) { return static_cast<std::uint32_t>(value) ^ 0x8000'0000U; };
    return std::uint64_t{biased(point.x)} << 32 | biased(point.y);
}

/// The x of the point that the key was made of.
constexpr std::int32_t x_of(std::uint64_t key) noexcept {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(key >> 32) ^ 0x8000'0000U);
}

constexpr std::int32_t y_of(std::uint64_t key) noexcept {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(key) ^ 0x8000'0000U);
}

/// Sorts keys whose indices ascend by (key, index). Throws std::bad_alloc, and Stopped where `pace` follows a host that
/// wants the call to end.
void sort_keys(Vector<SortKey>& keys, Vector<SortKey>& spare, StopPace& pace);

/// Sorts each run of equal keys by `before`. Precondition: keys are sorted.
template <class Before>
void sort_equal_keys(Vector<SortKey>& keys, const Before& before) {
    const auto equal = [](const SortKey& a, const SortKey& b) { return a.key == b.key; };
    for (auto run = std::adjacent_find(keys.begin(), keys.end(), equal); run != keys.end();) {
        const auto end = std::find_if(run, keys.end(), [run](const SortKey& key) { return key.key != run->key; });
        std::sort(run, end, before);
        run = std::adjacent_find(end, keys.end(), equal);
    }
}

}  // namespace lamella::nesting
