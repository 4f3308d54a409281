// Facts of a closed contour for order and nesting: its start, box and area.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/function_ref.hpp"
#include "base/numbers.hpp"
#include "slicing/grid/box.hpp"

namespace lamella {

/// Found in one pass over a closed contour.
struct RingFacts {
    FlatBox box;
    Int128 twice_area;     ///< positive if counter-clockwise; exact
    std::size_t smallest;  ///< index of the first occurrence of the smallest (x, y)
    bool many_smallest;    ///< it occurs again
    bool has_repeats;      ///< two consecutive points are equal
};

/// Twice the area is the sum over i of x[i] · (y[i + 1] - y[i - 1]): one product a point, x counted from the first point.
/// Differences have 32 bits and a sign, so a product fits 64 bits and a sum of them need not: the halves are summed apart.
class ProductSum {
public:
    void add(std::int64_t product) noexcept {
        low_ += static_cast<std::uint32_t>(product);
        high_ += product >> 32;
    }
    Int128 total() const noexcept { return (Int128{high_} << 32) + Int128{low_}; }

private:
    std::uint64_t low_ = 0;
    std::int64_t high_ = 0;
};

/// point(i) is the ring's i-th point; each is read once.
template <class PointAt>
RingFacts facts_of(std::size_t count, const PointAt& point) {
    const Point first = point(0);
    RingFacts facts{{first, first}, 0, 0, false, false};
    Point smallest = first;
    ProductSum sum;
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
        sum.add((std::int64_t{here.x} - first.x) * (std::int64_t{next.y} - before.y));
        before = here;
        here = next;
    }
    facts.twice_area = sum.total();
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
