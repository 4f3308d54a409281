// Numbers that are the same on every platform, as the C library's sine is not.
#pragma once

#include <cfloat>
#include <cstdint>

#include "base/numbers.hpp"

namespace lamella::models {

static_assert(FLT_EVAL_METHOD == 0, "intermediate results in extended precision would change the bytes");

inline constexpr double tau = 6.283185307179586476925286766559;

struct SinCos {
    double sin = 0;
    double cos = 1;
};

/// Sine and cosine of an angle in turns, |turns| < 2^52; within 2e-16 for small angles.
inline SinCos sincos_turns(double turns) noexcept {
    double fraction = turns - static_cast<double>(static_cast<std::int64_t>(turns));
    if (fraction < 0) {
        fraction += 1;
    }
    const int quarter = static_cast<int>(fraction * 8 + 1) / 2;  // the nearest quarter turn
    // Taylor series on [-pi/4, pi/4]; the first omitted terms are below 2^-54.
    const double r = (fraction - quarter * 0.25) * tau;
    const double q = -r * r;
    double s = 1;
    double c = 1;
    for (int k = 16; k >= 2; k -= 2) {
        s = 1 + s * q / (k * (k + 1));
        c = 1 + c * q / (k * (k - 1));
    }
    const SinCos at{r * s, c};
    switch (quarter & 3) {
        case 0:
            return at;
        case 1:
            return {at.cos, -at.sin};
        case 2:
            return {-at.sin, -at.cos};
        default:
            return {-at.cos, at.sin};
    }
}

/// The random number generator SplitMix64.
class Random {
public:
    explicit Random(std::uint64_t seed) noexcept : state_(seed) {}
    std::uint64_t next() noexcept { return mix64(state_ += 0x9e3779b97f4a7c15U); }
    /// A number in [0, 1).
    double unit() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// A number in [0, bound).
    std::uint32_t below(std::uint32_t bound) noexcept { return static_cast<std::uint32_t>(((next() >> 32) * bound) >> 32); }

private:
    std::uint64_t state_;
};

}  // namespace lamella::models
