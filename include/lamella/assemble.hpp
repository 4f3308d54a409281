// Contours from segments that the caller brings: for programs that cut something else than triangles.
//
//     // A square. Two segments meet where their keys are equal, here the number of the corner.
//     const lamella::Point corners[4] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
//     std::vector<lamella::Segment> segments;
//     for (std::uint64_t i = 0; i < 4; ++i) {
//         const std::uint64_t next = (i + 1) % 4;
//         segments.push_back({.from_key = {i}, .to_key = {next}, .from = corners[i], .to = corners[next]});
//     }
//     const lamella::Result<lamella::LayerContours> square = lamella::assemble(segments);
//     if (square) {
//         std::printf("%zu contour, %g mm2\n", square->contours.size(), square->area_mm2());
//     }
//
// Source: the paper's Algorithm 4, with keys for what it calls vertices.
#pragma once

#include <compare>
#include <cstdint>
#include <span>

#include "lamella/array.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"
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

/// One layer's contours: oriented, nested and in canonical order, as in SliceResult; parents index `contours`.
struct LayerContours {
    Array<Contour> contours;
    Array<Point> points;
    double unit_mm = default_unit_mm;  ///< of the grid: region_of() sets what it is given, assemble() leaves the default

    /// Of all contours and of one, as SliceResult::area_mm2().
    double area_mm2() const noexcept;
    double area_mm2(const Contour& contour) const noexcept;
};

/// Links q segments of one plane, given in any order, into contours. Every segment is used exactly once. Ends that meet are
/// paired by orientation, then by rank: each segment that comes in with the next one clockwise that goes out, so that the
/// solid between them is on the left and contours do not cross. What is left is paired whatever its orientation, and an odd
/// end becomes the end of an open polyline. Points are in grid units: their magnitude is at most grid_limit.
///
/// O(q) expected for linking, O(q log q) for order and nesting. It works on the calling thread; of `control` it uses
/// `memory`, for the result and all scratch, `stop` and `progress`. Errors: invalid_argument
/// (more than 2^30 segments, negative threads), out_of_memory, cancelled.
Result<LayerContours> assemble(std::span<const Segment> segments, const Control& control = {}) noexcept;

}  // namespace lamella
