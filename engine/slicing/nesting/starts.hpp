// The starts of a layer's rings by x, and which of them lie in a box.
#pragma once

#include <cstdint>
#include <limits>

#include "base/eight.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella::nesting {

/// Starts in the order of x, of which eight are compared at once. Those in the box of a ring follow the ring's own, up to
/// the box's right side:
///
///     starts   [ . . . . ring . . . . . . . | . . . ]      |: the first beyond the box
class StartLine {
public:
    explicit StartLine(const Memory* memory) : xs_(memory), ys_(memory) {}

    /// The start of each of `count` rings. Throws std::bad_alloc.
    template <class StartOf>
    void assign(std::size_t count, StartOf start_of) {
        xs_.assign(count + Int32x8::lanes, std::numeric_limits<std::int32_t>::max());  // what lies behind is in no box
        ys_.assign(count + Int32x8::lanes, nowhere);
        for (std::size_t i = 0; i < count; ++i) {
            const Point start = start_of(i);
            xs_[i] = start.x;
            ys_[i] = start.y;
        }
    }
    void take_off(std::uint32_t start) noexcept { ys_[start] = nowhere; }

    /// Calls take(start) for those from `first` on that meet the box and are not taken off. Returns how often it compared
    /// eight.
    template <class Take>
    std::size_t find(std::uint32_t first, const FlatBox& box, Take take) const {
        for (std::size_t steps = 1;; ++steps, first += Int32x8::lanes) {
            const std::int32_t* const xs = xs_.data() + first;
            const Int32x8 apart =
                beyond(Int32x8(xs), box.low.x, box.high.x) | beyond(Int32x8(ys_.data() + first), box.low.y, box.high.y);
            each_lane(~apart.bits() & all_eight, [&](std::size_t lane) { take(first + static_cast<std::uint32_t>(lane)); });
            if (xs[Int32x8::lanes - 1] > box.high.x) {
                return steps;
            }
        }
    }

private:
    static constexpr std::int32_t nowhere = std::numeric_limits<std::int32_t>::min();

    static Int32x8 beyond(const Int32x8& values, std::int32_t low, std::int32_t high) noexcept {
        return (Int32x8(low) > values) | (values > Int32x8(high));
    }

    Vector<std::int32_t> xs_, ys_;
};

}  // namespace lamella::nesting
