// Where a path turns: the loop of the search for edges near one another that goes through all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// There is room for so many points after the last.
constexpr std::size_t turn_lanes = 32;

/// Writes the edges before which a path turns: which goes left where one since the last turn went right, or down where one
/// went up, or the other way round. Edge i leads from points[i] to points[i + 1]. Returns how many; `out` has room for
/// `edges`.
using FindTurns = std::size_t (*)(const Point* points, std::size_t edges, std::uint32_t* out);

std::span<const Form<FindTurns>> find_turns_forms() noexcept;

}  // namespace lamella
