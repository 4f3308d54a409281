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
/// O(c log c) for a layer of c monotone runs of edges, and for two runs whose boxes meet as many steps as they have edges
/// close to each other. A layer that takes more than 1,024 steps an edge is not searched to its end: at_least. Only
/// thousands of long slanting edges side by side make that happen. The answer does not depend on threads. Errors:
/// invalid_argument (layers, contours and points do not follow one another, negative threads), out_of_memory, cancelled.
Result<Crossings> find_crossings(const SliceResult& result, const Control& control = {}) noexcept;

}  // namespace lamella
