// An edge of the mesh on the grid: segments whose ends lie on the same edge meet there. With its hash, the one that every
// map of edges uses.
#pragma once

#include <cstdint>
#include <cstring>

#include "base/little_endian.hpp"
#include "base/numbers.hpp"
#include "base/system/processor.hpp"
#include "lamella/grid.hpp"
#include "lamella/layers.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

/// An edge as its two vertices lie in memory, `lower` first, in words that are quick to compare and to hash:
///
///     [ lower.x | lower.y ] [ lower.z | upper.x ] [ upper.y | upper.z ]      32 bits each
struct MeshEdge {
    std::uint64_t words[3];

    static MeshEdge between(const GridVertex& lower, const GridVertex& upper) noexcept {
        MeshEdge edge;
        std::memcpy(&edge.words[0], &lower.x, sizeof edge.words[0]);
        edge.words[1] = joined(lower.z, upper.x);
        std::memcpy(&edge.words[2], &upper.y, sizeof edge.words[2]);
        return edge;
    }

    GridVertex lower() const noexcept { return vertex(0); }
    GridVertex upper() const noexcept { return vertex(sizeof(GridVertex)); }

    /// The same on every platform. Tables take their index from the high bits, which are well mixed.
    std::uint64_t hash() const noexcept {
        std::uint64_t h = words[0] * 0x9E3779B97F4A7C15U + words[1] * 0xC2B2AE3D27D4EB4FU + words[2] * 0x165667B19E3779F9U;
        h ^= h >> 32;
        return h * 0xD6E8FEB86659FD93U;
    }

    friend bool operator==(const MeshEdge&, const MeshEdge&) = default;

private:
    /// Two coordinates as they lie in memory. Shifted together: compilers join an array by way of vector registers.
    static std::uint64_t joined(std::int32_t first, std::int32_t second) noexcept {
        return static_cast<std::uint32_t>(first) | static_cast<std::uint64_t>(static_cast<std::uint32_t>(second)) << 32;
    }

    GridVertex vertex(std::size_t at) const noexcept {
        GridVertex v;
        std::memcpy(static_cast<void*>(&v), reinterpret_cast<const char*>(words) + at, sizeof v);
        return v;
    }
};

/// An edge as a key, which compares as the vertices do: sign bits flipped, first coordinate in the highest bits.
inline EndKey to_key(const MeshEdge& edge) noexcept {
    const auto word = [](std::int32_t high, std::int32_t low) {
        return ((static_cast<std::uint64_t>(static_cast<std::uint32_t>(high)) << 32) | static_cast<std::uint32_t>(low)) ^
               0x8000000080000000U;
    };
    const GridVertex lower = edge.lower();
    const GridVertex upper = edge.upper();
    return {word(lower.x, lower.y), word(lower.z, upper.x), word(upper.y, upper.z)};
}

/// The reverse of to_key().
inline MeshEdge from_key(const EndKey& key) noexcept {
    const auto high = [](std::uint64_t word) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(word >> 32) ^ 0x80000000U);
    };
    const auto low = [](std::uint64_t word) {
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(word) ^ 0x80000000U);
    };
    return MeshEdge::between({high(key.a), low(key.a), high(key.b)}, {low(key.b), high(key.c), low(key.c)});
}

/// Added to a move along an edge and taken off again, it leaves multiples of 2^-20 units: a slope's own rounding does not
/// decide a tie.
inline constexpr double tie_room = 0x1.8p32;

/// A move of less than 2^31 units, rounded by itself, so that contours do not depend on where a mesh stands.
inline std::int32_t round_move(double units) noexcept {
    return round_to_int(units + tie_room - tie_room);
}

/// Where an edge that does not lie level pierces the plane at `z`, which is between its ends; the arithmetic of
/// Kernels::pierce.
inline Point pierced_point(const MeshEdge& edge, std::int32_t z) noexcept {
    const GridVertex lower = edge.lower();
    const GridVertex upper = edge.upper();
    const double height = static_cast<double>(upper.z) - lower.z;
    const double slope_x = (static_cast<double>(upper.x) - lower.x) / height;
    const double slope_y = (static_cast<double>(upper.y) - lower.y) / height;
    const auto rise = static_cast<double>(std::int64_t{z} - lower.z);
    return {lower.x + round_move(slope_x * rise), lower.y + round_move(slope_y * rise)};
}

// Hashes of a grid vertex, the same on every platform.

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
