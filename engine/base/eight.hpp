// Int32x8 32-bit integers that are compared at once, with what every compiler and processor has: vectors of four.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/system/lanes.hpp"
#include "base/system/processor.hpp"

namespace lamella {

/// A bit for each of eight lanes.
using LaneBits = unsigned;
constexpr LaneBits all_eight = 0xFF;

/// Calls visit(lane) for each bit that is set, from the lowest.
template <class Visit>
void each_lane(LaneBits bits, Visit visit) {
    for (; bits != 0; bits &= bits - 1) {
        visit(static_cast<std::size_t>(std::countr_zero(bits)));
    }
}

class Int32x8 {
public:
    static constexpr std::size_t lanes = 8;
    /// As they lie in memory, where lanes are read and written one by one.
    using Stored = std::array<std::int32_t, lanes>;

    explicit Int32x8(std::int32_t all) noexcept : low_{all, all, all, all}, high_{all, all, all, all} {}
    explicit Int32x8(const Stored& stored) noexcept : Int32x8(stored.data()) {}
    /// Eight of an array.
    explicit Int32x8(const std::int32_t* first) noexcept {
        std::memcpy(&low_, first, sizeof low_);
        std::memcpy(&high_, first + lanes / 2, sizeof high_);
    }

    /// Lanes of -1 where it holds, else 0.
    friend Int32x8 operator>(const Int32x8& a, const Int32x8& b) noexcept { return {a.low_ > b.low_, a.high_ > b.high_}; }
    friend Int32x8 operator==(const Int32x8& a, const Int32x8& b) noexcept { return {a.low_ == b.low_, a.high_ == b.high_}; }
    friend Int32x8 operator|(const Int32x8& a, const Int32x8& b) noexcept { return {a.low_ | b.low_, a.high_ | b.high_}; }

    /// The lanes that are -1; all are -1 or 0.
    LaneBits bits() const noexcept { return bits_of(low_) | bits_of(high_) << 4; }

private:
    Int32x8(FourInts low, FourInts high) noexcept : low_(low), high_(high) {}

    static LaneBits bits_of(FourInts four) noexcept {
#ifdef LAMELLA_SSE2
        return static_cast<LaneBits>(_mm_movemask_ps(reinterpret_cast<__m128>(four)));
#else
        return static_cast<LaneBits>((four[0] & 1) | (four[1] & 2) | (four[2] & 4) | (four[3] & 8));
#endif
    }

    FourInts low_;
    FourInts high_;
};

}  // namespace lamella
