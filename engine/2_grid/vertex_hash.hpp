// A hash of a grid vertex, the same on every platform.
#pragma once

#include <cstdint>

#include "2_grid/quantise.hpp"

namespace lamella {

/// SplitMix64's finaliser.
inline std::uint64_t mixed(std::uint64_t word) noexcept {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9U;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBU;
    return word ^ (word >> 31);
}

inline std::uint64_t hash_of(const GridVertex& v) noexcept {
    const std::uint64_t xy = std::uint64_t{static_cast<std::uint32_t>(v.x)} << 32 | static_cast<std::uint32_t>(v.y);
    return mixed(mixed(xy + 0x9E3779B97F4A7C15U) + static_cast<std::uint32_t>(v.z));
}

}  // namespace lamella
