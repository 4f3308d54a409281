// Facts of a closed contour for order and nesting: its start, box and area. Order of contours by their starts, and of
// anything else by a 64-bit key.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "base/function_ref.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/sort.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella::nesting {

/// A key and the number of the element that it belongs to.
struct SortKey {
    std::uint64_t key = 0;
    std::uint32_t index = 0;
};

/// By key, then index. No function, which std::sort would call by its address.
inline constexpr auto before = [](const SortKey& a, const SortKey& b) noexcept {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
};

/// Orders as points do: by x, then y. This is the order of starts: layers are sorted by it, a parent therefore starts before
/// its children, and windows of starts reach to the right. RingFacts finds the start by the same order, and audit() and
/// canonical_order rely on it.
constexpr std::uint64_t key_of(Point point) noexcept {
    const auto biased = [](std::int32_t value) { return static_cast<std::uint32_t>(value) ^ 0x8000'0000U; };
    return std::uint64_t{biased(point.x)} << 32 | biased(point.y);
}

/// The point that the key was made of.
constexpr Point point_of(std::uint64_t key) noexcept {
    const auto coordinate = [](std::uint64_t biased) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(biased) ^ 0x8000'0000U);
    };
    return {coordinate(key >> 32), coordinate(key)};
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
        sort_briefly(run, end, before);
        run = std::adjacent_find(end, keys.end(), equal);
    }
}

}  // namespace lamella::nesting

namespace lamella {

/// Found in one pass over a closed contour.
struct RingFacts {
    FlatBox box;
    Int128 twice_area;     ///< positive if counter-clockwise; exact
    std::size_t smallest;  ///< index of the first occurrence of the smallest (x, y)
    bool many_smallest;    ///< it occurs again
    bool has_repeats;      ///< two consecutive points are equal
};

/// point(i) is the ring's i-th point; each is read once. Twice the area is the sum over i of x[i] · (y[i + 1] - y[i - 1]):
/// one product a point, x counted from the first point. A product fits 64 bits, and a sum of them need not.
template <class PointAt>
RingFacts facts_of(std::size_t count, const PointAt& point) {
    const Point first = point(0);
    RingFacts facts{{first, first}, 0, 0, false, false};
    Point smallest = first;
    Point before = point(count - 1);
    Point here = first;
    for (std::size_t i = 0; i < count; ++i) {
        const Point next = i + 1 < count ? point(i + 1) : first;
        facts.box.include({here, here});
        facts.has_repeats = facts.has_repeats || here == next;
        if (here < smallest) {
            smallest = here;
            facts.smallest = i;
            facts.many_smallest = false;
        } else if (i > 0 && here == smallest) {
            facts.many_smallest = true;
        }
        facts.twice_area += (std::int64_t{here.x} - first.x) * (std::int64_t{next.y} - before.y);
        before = here;
        here = next;
    }
    return facts;
}

/// The facts of a closed ring of count > 0 points as they lie.
inline RingFacts examine_ring(const Point* ring, std::size_t count) noexcept {
    return facts_of(count, [ring](std::size_t i) { return ring[i]; });
}
/// The same for a long one: calls pause() now and then, which may throw.
inline RingFacts examine_ring(const Point* ring, std::size_t count, FunctionRef<void()> pause) {
    constexpr std::size_t points_between_pauses = std::size_t{1} << 18;
    return facts_of(count, [ring, pause](std::size_t i) {
        if (i % points_between_pauses == 0) {
            pause();
        }
        return ring[i];
    });
}

}  // namespace lamella
