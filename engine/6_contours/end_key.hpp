// What two segment ends must share to meet: the mesh edge, packed so that keys compare as its vertices do.
#pragma once

#include <cstdint>

#include "lamella/assemble.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// The edge between `lower` and `upper`, in that order:
///
///     a [ lower.x | lower.y ]  b [ lower.z | upper.x ]  c [ upper.y | upper.z ]      32 bits each, sign bit flipped
inline EndKey pack_edge(const GridVertex& lower, const GridVertex& upper) noexcept {
    const auto word = [](std::int32_t high, std::int32_t low) {
        return ((static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)) << 32) | static_cast<std::uint32_t>(low)) ^
               0x8000000080000000U;
    };
    return {word(lower.x, lower.y), word(lower.z, upper.x), word(upper.y, upper.z)};
}

/// The reverse of pack_edge().
inline void unpack_edge(const EndKey& key, GridVertex& lower, GridVertex& upper) noexcept {
    const auto high = [](std::uint64_t word) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(word >> 32) ^ 0x80000000U);
    };
    const auto low = [](std::uint64_t word) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(word) ^ 0x80000000U);
    };
    lower = {high(key.a), low(key.a), high(key.b)};
    upper = {low(key.b), high(key.c), low(key.c)};
}

/// Well mixed in its high bits, which is where the table takes its index from.
inline std::uint64_t hash_key(const EndKey& key) noexcept {
    std::uint64_t h = key.a * 0x9E3779B97F4A7C15U;
    h ^= (key.b ^ (h >> 29)) * 0xC2B2AE3D27D4EB4FU;
    h ^= (h >> 32) ^ (key.c * 0x165667B19E3779F9U);
    return h * 0x9E3779B97F4A7C15U;
}

}  // namespace lamella
