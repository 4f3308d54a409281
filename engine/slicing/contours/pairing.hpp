// Pairs the ends of segments that meet at one edge, where more than two do (or two of the same orientation): by orientation,
// then by angle.
//
// The ends are sorted counter-clockwise round the edge, seen from above. The solid begins at an end that goes out (its left
// is the counter-clockwise side) and ends at one that comes in: "out" opens a bracket, "in" closes it. Matching brackets
// share a wedge of solid, so contours paired this way never cross:
//
//              out                          four faces, two solids that touch along the edge:
//               | solid A                       out in out in   ->   (out in) (out in)
//        -------+------- in
//     in        |                           a solid with a wedge-shaped gap of solid in its gap ...:
//       solid B | out                           out out in in   ->   (out (out in) in)
//
// The ends left over have one orientation. Each pairs with its neighbour round the edge, and an odd one ends an open
// polyline.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/function_ref.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/contours/slot_table.hpp"

namespace lamella {

/// An end of link `link` at an edge.
struct MeetingEnd {
    std::uint32_t link;
    bool is_source;  ///< goes out from the edge
};

class Pairing {
public:
    explicit Pairing(const Memory* memory) : pairs_(memory), stack_(memory), unmatched_(memory) {}

    /// Pairs `ends`, which lie counter-clockwise; bracket matching goes round from the last to the first. O(ends).
    void match(std::span<const MeetingEnd> ends);

    /// Indices into the ends; where the orientations differ, the one that comes in is first.
    std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs() const noexcept { return pairs_; }
    /// Index of the end that found no partner, or -1.
    std::int64_t odd_one() const noexcept { return odd_; }

private:
    Vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
    Vector<std::uint32_t> stack_;
    Vector<std::uint32_t> unmatched_;
    std::int64_t odd_ = -1;
};

/// A face at a mesh edge.
struct FaceAtEdge {
    GridVertex apex;  ///< its vertex off the edge
    std::uint32_t triangle;
    MeetingEnd end;
};

/// Sorts the faces of the edge from `lower` to `upper` counter-clockwise seen from above, starting at the smallest apex. At
/// equal angles those that come in are first (they close the solid before them), by apex, then those that go out, in the
/// opposite order, so that brackets nest. Faces that are the same in all of this are interchangeable; the triangle's index
/// only keeps each of them in the same place at all its edges. Exact.
void sort_round_edge(const GridVertex& lower, const GridVertex& upper, std::span<FaceAtEdge> faces);

/// Edges where more than two ends meet, or two of one orientation: which segment goes on as which. A rare step between
/// attaching and connecting.
class Meetings {
public:
    explicit Meetings(const Memory* memory) : ends_(memory), pairing_(memory) {}

    /// Sorts the ends that meet at a slot counter-clockwise round its edge.
    using Order = FunctionRef<void(Slot, std::span<MeetingEnd>)>;
    /// Called with (to, from) when a slot is made for the edge of another.
    using Copied = FunctionRef<void(Slot, Slot)>;

    /// Pairs what meets at the fresh slots, marks open ends, corrects `links` where it gives an end another slot; true if
    /// there is such an end. Precondition: end_attaching().
    bool settle(SlotTable& slots, std::span<Link> links, Order order, Copied copied);

private:
    void settle_irregular(SlotTable& slots, std::span<Link> links, Order order, Copied copied);
    void seat_pairs(SlotTable& slots, Slot slot, std::span<Link> links, Copied copied) const;

    Vector<MeetingEnd> ends_;  // that meet at one slot
    Pairing pairing_;
};

}  // namespace lamella
