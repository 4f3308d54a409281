// Layers of contours that are not cut from a mesh. Each call gives a result of one layer, at height 0.
//
//     // Two squares that overlap become one contour of eight points.
//     const lamella::Point low[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
//     const lamella::Point high[] = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
//     const std::span<const lamella::Point> squares[] = {low, high};
//     const auto region = lamella::region_of(squares, {.fill_rule = lamella::FillRule::non_zero}, 0.5);  // mm a grid unit
//     if (region) {
//         std::printf("%zu points, %g mm2\n", region->points.size(), (*region)[0].area_mm2());
//     }
//
//     // A square of segments. Two meet where their keys are equal, here the number of the corner.
//     std::vector<lamella::Segment> segments;
//     for (std::uint64_t i = 0; i < 4; ++i) {
//         const std::uint64_t next = (i + 1) % 4;
//         segments.push_back({.from_key = {i}, .to_key = {next}, .from = low[i], .to = low[next]});
//     }
//     const auto square = lamella::assemble(segments);
//
// The contours of a region have their solid on the left and cross nowhere, but may touch in points. Solid does not hang
// together by a point, what is empty does:
//
//     .---.            .-----------.
//     |   |            | .--.      |
//     '---o---.        | |  |      |
//         |   |        | '--o--.   |
//         '---'        |    |  |   |
//                      |    '--'   |
//                      '-----------'
//     two outers       an outer, and one hole, which passes `o` twice
//
// A hole that touches the contour around it is no hole: the outer passes that point twice.
//
// A given contour that no step changes stays as it is: points, start, Contour::segments and the flags stitched and
// orientation_mixed. One that was made, of one or several, starts at its smallest (x, y); its `segments` are its edges, its
// flags are empty but for would_close, and its `part` is that of all its edges or several_parts. No contour of a region is
// orientation_overruled: the rule decides roles. Layer::segments counts triangles, whatever the rules make of them.
//
// Source: the paper's Algorithm 4, with keys for what it calls vertices; the regions are our own.
#pragma once

#include <compare>
#include <cstdint>
#include <span>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
#include "lamella/options.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What tells two segment ends apart: ends with equal keys meet. The engine uses the mesh edge (its two quantised end
/// vertices), never the rounded point: contours that touch after rounding must not fuse.
struct EndKey {
    std::uint64_t a = 0;
    std::uint64_t b = 0;
    std::uint64_t c = 0;
    friend constexpr auto operator<=>(const EndKey&, const EndKey&) = default;

    /// The key of the mesh edge between two vertices, whichever comes first. Order: by (x, y, z) of the lower end, then the
    /// upper.
    static EndKey of_edge(GridVertex u, GridVertex v) noexcept;
};

/// A directed segment with the solid on its left. `rank` orders the segments that meet at a key, counter-clockwise around
/// it; it matters only where more than two meet.
struct Segment {
    EndKey from_key;
    EndKey to_key;
    Point from;
    Point to;
    std::uint32_t from_rank = 0;
    std::uint32_t to_rank = 0;
};

/// Links q segments of one plane, given in any order, into contours. Every segment is used exactly once. Ends that meet are
/// paired by orientation, then by rank: each segment that comes in with the next one clockwise that goes out, so that the
/// solid between them is on the left and contours do not cross. What is left is paired whatever its orientation, and an odd
/// end becomes the end of an open polyline. Points are in grid units: their magnitude is at most grid_limit.
///
/// O(q) expected for linking, O(q log q) for order and nesting. It works on the calling thread; of the context it uses
/// `memory`, for the result and all scratch, and `stop`. Errors: invalid_argument
/// (more than 2^30 segments, negative threads), out_of_memory, cancelled.
Result<SliceResult> assemble(std::span<const Segment> segments, const Context& context = {}) noexcept;

/// The region that closed contours bound, with outers and holes, parents, and in the order of SliceResult. A contour's last
/// point leads to its first; equal consecutive points count once. `grid_mm` is what a grid unit of the points is.
///
/// O((m + c) log (m + c)) for m points and c places where edges come within two units of one another; memory O(m + c). It
/// works on the calling thread; of the context it uses `memory`, for the result and all scratch, and `stop`. Errors:
/// invalid_argument (negative threads, a grid_mm that is not finite and above 0, a rule that is out of range, a point beyond
/// grid_limit, offsets that may reach beyond it, more than 2^30 points), out_of_memory, cancelled.
Result<SliceResult> region_of(std::span<const std::span<const Point>> contours, const RegionRules& rules,
                              double grid_mm = default_grid_mm, const Context& context = {}) noexcept;

}  // namespace lamella
