// Steps of y that hold the points of ManyInside, and the edges that reach a step with a point in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/dispatch.hpp"
#include "lamella/grid.hpp"

namespace lamella::nesting {

/// The range of y in steps of 2^shift; the first and the last hold no point and take all y below and above.
///
///     ends     step s holds points ends[s] to ends[s + 1], in the order of y
struct QuerySteps {
    std::int32_t low, high;
    int shift;
    const std::uint32_t* ends;

    std::uint32_t of(std::int32_t y) const noexcept {
        const std::int32_t within = y < low ? low : (y < high ? y : high);
        return (static_cast<std::uint32_t>(within) - static_cast<std::uint32_t>(low)) >> shift;
    }
};

/// Edges points[edge[i]], points[edge[i] + 1] that reach the steps of points begin[i] to end[i].
struct Reaches {
    static constexpr std::uint32_t most = 128;
    static constexpr std::uint32_t padding = 16;  // a form may write beyond what it finds
    std::uint32_t edge[most + padding];
    std::uint32_t begin[most + padding];
    std::uint32_t end[most + padding];
};

/// Those of the `count` <= Reaches::most edges from points[0] to points[count] that reach a step with a point; how many.
using SiftEdges = std::size_t (*)(const QuerySteps& steps, const Point* points, std::uint32_t count,
                                  Reaches& reaches) noexcept;

/// All forms, the fastest first.
std::span<const Form<SiftEdges>> sift_edges_forms() noexcept;

}  // namespace lamella::nesting
