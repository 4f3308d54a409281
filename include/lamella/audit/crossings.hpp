// Where contours of a layer cross one another or themselves: the mesh runs through itself there.
//
//     const lamella::Result<lamella::Crossings> crossings = lamella::find_crossings(result);
//     if (crossings && crossings->count > 0) {
//         const lamella::LayerCrossings& first = crossings->layers[0];
//         const lamella::PointMm at = result.to_mm(first.first);
//         std::printf("layer %zu, first at %g %g\n", static_cast<std::size_t>(first.layer), at.x, at.y);
//     }
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// Where a layer has so many, no more are searched for.
inline constexpr std::uint64_t most_crossings_in_layer = 4096;

/// The crossings in one layer that has any.
struct LayerCrossings {
    std::uint64_t layer = 0;  ///< index into SliceResult::layers
    std::uint64_t count = 0;
    bool at_least = false;                        ///< the search was cut short
    Point first;                                  ///< the one with the smallest x, then y, rounded to the grid
    std::array<std::uint64_t, 2> contours{0, 0};  ///< that cross there, as indices into SliceResult::contours, ascending
};

struct Crossings {
    std::uint64_t count = 0;
    bool at_least = false;
    std::vector<LayerCrossings> layers;  ///< ascending
};

/// Counts where one path goes from one side of another to the other, exactly, on the points of the result: edges whose
/// insides cross, and corners in which a path passes through another's edge or corner. A path that only touches another, or
/// runs along a stretch of it, does not cross it there. The end of an open polyline crosses nothing. An outline that is
/// traced twice, as flat contours may be, crosses another twice.
///
/// O(m log m + c) for a layer of m edges with c crossings, of which at most most_crossings_in_layer are counted. A layer
/// that takes more than 64 steps an edge for each bit of m is not searched to its end. In both cases it has `at_least` so
/// many, and `first` is the first of those found. Only thousands of long slanting edges side by side take more steps. The
/// layers are shared out to threads, as are the parts of a layer of more than 2^17 edges, and the answer does not depend on
/// them. Errors: invalid_argument (layers, contours and points do not follow one another, negative threads), out_of_memory,
/// cancelled.
Result<Crossings> find_crossings(const SliceResult& result, const Control& control = {}) noexcept;

}  // namespace lamella
