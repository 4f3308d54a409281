// Hashes of a grid vertex, the same on every platform.
#pragma once

#include <cstdint>

#include "base/numbers.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

inline std::uint64_t hash_of(const GridVertex& v) noexcept {
    const std::uint64_t xy = std::uint64_t{static_cast<std::uint32_t>(v.x)} << 32 | static_cast<std::uint32_t>(v.y);
    return mix64(mix64(xy + 0x9E3779B97F4A7C15U) + static_cast<std::uint32_t>(v.z));
}

/// The same by one multiplication. No factor is 0, as coordinates are even.
inline std::uint64_t quick_hash_of(const GridVertex& v) noexcept {
    const std::uint64_t xy = std::uint64_t{static_cast<std::uint32_t>(v.x)} << 32 | static_cast<std::uint32_t>(v.y);
    return mul_fold(xy ^ 0x9E3779B97F4A7C15U, static_cast<std::uint32_t>(v.z) ^ 0xBF58476D1CE4E5B9U);
}

}  // namespace lamella
