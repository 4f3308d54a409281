// What two segment ends must share to meet: the mesh edge that they lie on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/little_endian.hpp"
#include "lamella/assemble.hpp"
#include "lamella/grid.hpp"
#include "slicing/buckets/crossed_triangle.hpp"

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

    /// Well mixed in its high bits, which is where tables take their index from.
    std::uint64_t hash() const noexcept {
        std::uint64_t h = words[0] * 0x9E3779B97F4A7C15U + words[1] * 0xC2B2AE3D27D4EB4FU + words[2] * 0x165667B19E3779F9U;
        h ^= h >> 32;
        return h * 0xD6E8FEB86659FD93U;
    }

    friend bool operator==(const MeshEdge&, const MeshEdge&) = default;

private:
    /// Two coordinates as they lie in memory. Shifted together: compilers join an array by way of vector registers.
    static std::uint64_t joined(std::int32_t first, std::int32_t second) noexcept {
        const std::uint64_t a = static_cast<std::uint32_t>(first);
        const std::uint64_t b = static_cast<std::uint32_t>(second);
        return a | b << 32;
    }

    GridVertex vertex(std::size_t at) const noexcept {
        GridVertex v;
        std::memcpy(static_cast<void*>(&v), reinterpret_cast<const char*>(words) + at, sizeof v);
        return v;
    }
};

/// The edge from a triangle's lowest vertex to its highest.
inline MeshEdge long_edge(const CrossedTriangle& t) noexcept {
    return MeshEdge::between(t.lower, t.upper);
}

/// The one above the middle vertex, or the one below it. Nothing predicts which is asked for: the two are neighbours in
/// memory, and it is the address that is reckoned.
inline MeshEdge short_edge(const CrossedTriangle& t, bool above_middle) noexcept {
    static_assert(offsetof(CrossedTriangle, lower) == 0 && offsetof(CrossedTriangle, middle) == sizeof(GridVertex) &&
                  offsetof(CrossedTriangle, upper) == 2 * sizeof(GridVertex));
    const char* at = reinterpret_cast<const char*>(&t) + sizeof(GridVertex) * static_cast<std::size_t>(above_middle);
    MeshEdge edge;
    for (std::uint64_t& word : edge.words) {
        std::memcpy(&word, at, sizeof word);
        at += sizeof word;
    }
    return edge;
}

/// The same edge as a key, which compares as the vertices do: sign bits flipped, first coordinate in the highest bits.
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

}  // namespace lamella
