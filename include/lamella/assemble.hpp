// Contour construction for callers who bring their own segments (paper, Algorithm 4).
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
};

/// Links q segments of one plane, in any order, into contours. Every segment is used exactly once. Ends are paired by
/// sense, then by rank (each segment that comes in with the next one clockwise that goes out, so that the solid between them
/// is on the left and contours do not cross); what is left pairs ignoring sense, and an odd one ends an open polyline.
/// O(q) expected for linking, O(q log q) for order and nesting. Errors: out_of_memory.
Result<LayerContours> assemble(std::span<const Segment> segments, const Control& control = {}) noexcept;

}  // namespace lamella
