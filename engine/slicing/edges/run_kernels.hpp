// The two loops of the search for edges near one another that go through everything: where a path turns, and which boxes
// meet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Boxes side by side, each number in an array of its own that has room for run_lanes more.
struct BoxArrays {
    const std::int32_t* low_x;
    const std::int32_t* low_y;
    const std::int32_t* high_x;
    const std::int32_t* high_y;
    const std::uint32_t* run;  ///< whose box it is
};

constexpr std::size_t run_lanes = 8;
constexpr std::size_t turn_lanes = 32;

struct BoxesMet {
    std::size_t found;
    std::size_t beside;  ///< how many begin no higher than box i ends
};

struct RunKernels {
    /// Writes the edges before which a path turns: which goes left where one since the last turn went right, or down where
    /// one went up, or the other way round. Edge i leads from points[i] to points[i + 1]; there is room for turn_lanes
    /// points after the last. Returns how many; `out` has room for `edges`.
    std::size_t (*find_turns)(const Point* points, std::size_t edges, std::uint32_t* out);
    /// Writes which of the boxes (i, end), which are ordered by low_y, meet box i right of `from_x` or on it, but for those
    /// of the runs before and after its own. `out` has room for so many boxes.
    BoxesMet (*find_meeting)(const BoxArrays& boxes, std::size_t i, std::size_t end, std::int32_t from_x,
                             std::uint32_t* out);
};

std::span<const Form<RunKernels>> run_kernel_forms() noexcept;

}  // namespace lamella
