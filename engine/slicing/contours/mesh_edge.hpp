// The edges of a crossed triangle, and the key of an edge: segments whose ends lie on the same edge meet there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "base/little_endian.hpp"
#include "lamella/grid.hpp"
#include "lamella/layers.hpp"
#include "slicing/buckets/crossed_triangle.hpp"
#include "slicing/grid/mesh_edge.hpp"

namespace lamella {

/// The edge from a triangle's lowest vertex to its highest.
inline MeshEdge long_edge(const CrossedTriangle& t) noexcept {
    return MeshEdge::between(t.lower, t.upper);
}

/// The edge above the middle vertex, or the one below it. A branch would be mispredicted half of the time; the two lie side
/// by side in memory, so the address is computed instead.
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
