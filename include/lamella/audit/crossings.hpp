// Where contours of a layer cross one another or themselves: the mesh runs through itself there.
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

/// Counts where one path goes from one side of another to the other, on the points of the result, exactly: edges whose
/// insides cross, and corners in which a path passes through another's edge or corner. A path that only touches another, or
/// runs along a stretch of it, does not cross it there; where open polylines end nothing is passed through. An outline
/// traced twice, as flat contours may be, crosses another twice.
///
/// O(c log c) for a layer of c runs of edges that rise and fall neither in x nor in y between, and for runs whose boxes meet
/// as many steps as their edges lie close to each other. A layer in which that is more than 1,024 steps an edge, as only
/// long slanting edges side by side by the thousand make it, is not gone through to its end: at_least. The answer does not
/// depend on threads. Errors: invalid_argument (layers, contours and points do not follow one another),
/// out_of_memory.
Result<Crossings> find_crossings(const SliceResult& result, const Control& control = {}) noexcept;

}  // namespace lamella
