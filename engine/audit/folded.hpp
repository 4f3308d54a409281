// A hash by one multiplication, for where hash_of()'s four would take as long as all else.
#pragma once

#include <cstdint>

#include "lamella/grid.hpp"

namespace lamella {

/// 128 bits of a product, folded: every bit depends on most bits of both factors.
inline std::uint64_t folded(std::uint64_t a, std::uint64_t b) noexcept {
    __extension__ using Unsigned128 = unsigned __int128;
    const Unsigned128 product = Unsigned128{a} * b;
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

/// No factor is 0, as coordinates are even.
inline std::uint64_t folded(const GridVertex& v) noexcept {
    const std::uint64_t xy = std::uint64_t{static_cast<std::uint32_t>(v.x)} << 32 | static_cast<std::uint32_t>(v.y);
    return folded(xy ^ 0x9E3779B97F4A7C15U, static_cast<std::uint32_t>(v.z) ^ 0xBF58476D1CE4E5B9U);
}

}  // namespace lamella
