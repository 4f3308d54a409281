// Where a stretch of a contour lies furthest from the line that would replace it, by integers alone.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/numbers.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Of the points strictly between the ends of a chain.
struct ChainReach {
    std::size_t furthest;  ///< index of one to keep, should the chain be split
    bool within;           ///< all lie within the tolerance of the line between the ends
};

/// Of points[first] to points[last], last > first + 1. Distances are to the line from end to end, which stops there; a line
/// between equal ends replaces nothing. `tolerance` is in grid units, at most 2 grid_limit. O(last - first).
ChainReach measure_chain(const Point* points, std::size_t first, std::size_t last, std::int64_t tolerance) noexcept;

/// The largest whole number of which the square is at most `value`, which is below 2^126.
std::uint64_t floor_of_root(Int128 value) noexcept;

}  // namespace lamella
