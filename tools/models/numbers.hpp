// Numbers that are the same on every platform, as the C library's sine is not.
#pragma once

#include <cstdint>

namespace lamella::models {

inline constexpr double tau = 6.283185307179586476925286766559;

struct SinCos {
    double sin = 0;
    double cos = 1;
};

/// Sine and cosine of an angle in turns, |turns| < 2^52; within 2e-16 for small angles.
SinCos sincos_turns(double turns) noexcept;

/// The random number generator SplitMix64.
class Random {
public:
    explicit Random(std::uint64_t seed) noexcept : state_(seed) {}
    std::uint64_t next() noexcept;
    /// A number in [0, 1).
    double unit() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }
    /// A number in [0, bound).
    std::uint32_t below(std::uint32_t bound) noexcept { return static_cast<std::uint32_t>(((next() >> 32) * bound) >> 32); }

private:
    std::uint64_t state_;
};

}  // namespace lamella::models
