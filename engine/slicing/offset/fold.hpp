// Edges that an offset turns round, folded into the corner of their neighbours.
//
//     A notch with a short floor. Dilated, its walls meet before they have passed over the floor, which turns round; eroded
//     again, the walls run on to where their lines meet, at `x`:
//
//          a |       | d          the contour a b c d becomes a x d, whose curve is what is left of the curve of a b c d
//            |       |            when its loops are taken off: while the distance grows, the floor's moved edge shrinks
//            b-------c            to a point, from which on the walls' moved edges are neighbours.
//             \     /
//               \ /
//                x
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// The index of a point that is none of the contour's.
inline constexpr std::uint32_t no_point = 0xffffffff;

/// Appends to `points` the contour with the edges `turned`, ascending, replaced by points where the lines of their
/// neighbours meet, rounded, and to `indices` which of the contour's points each is, or no_point. Of edges side by side the
/// one that shrinks to a point first goes first, and others stay that no longer turn round. Edge i leads from point i to
/// point i + 1. `distance`: grid units, above 0. False, with nothing appended to `points`, where there is no such point to
/// the right of an edge; where an outer corner beside an edge passes the miter limit, so that its neighbours' moved edges do
/// not meet; where a neighbour becomes so short that rounding turns it; or where nearly all of the contour turns round.
/// O(points), and the square of edges that stand close together. Throws std::bad_alloc.
bool fold_edges(std::span<const Point> contour, std::span<const std::uint32_t> turned, double distance, double miter,
                Vector<Point>& points, Vector<std::uint32_t>& indices);

}  // namespace lamella
