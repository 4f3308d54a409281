// What measure_bounds() keeps of each block of 64 triangles. A block that lies between two planes and has no two vertices
// near each other is not read again: on a fine mesh these are most blocks.
#pragma once

#include <cstddef>

#include "lamella/array.hpp"
#include "lamella/memory.hpp"

namespace lamella {

inline constexpr std::size_t block_triangles = 64;

struct TriangleBlock {
    double low_mm;  ///< least and greatest z, transformed
    double high_mm;
    bool near;  ///< two vertices of one triangle lie within BlockTable::near_mm of each other on every axis
};

struct BlockTable {
    explicit BlockTable(const Memory* memory) : blocks(memory) {}

    /// Vertices that share a grid vertex are at most two units apart; twice that leaves room for rounding.
    static double near_mm_for(double unit_mm) noexcept { return 4 * unit_mm; }

    /// Whether a triangle of the block may have two equal vertices on a grid of `unit_mm`.
    bool may_be_degenerate(std::size_t block, double unit_mm) const noexcept {
        return blocks[block].near || near_mm < near_mm_for(unit_mm);
    }

    Array<TriangleBlock> blocks;  ///< block b: triangles from 64 b on
    double near_mm = 0;
};

inline std::size_t block_count(std::size_t triangles) noexcept {
    return (triangles + block_triangles - 1) / block_triangles;
}

}  // namespace lamella
