// The sectors around a point that are solid, exactly.
//
//            before
//              |  solid     Counter-clockwise from the edge that leaves a point to the one that came to it, as solids lie on
//     _________|. . . .     the left: `after` belongs to the sector, `before` does not.
//     void     at ---- after
#pragma once

#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Where a contour passes a point `at`.
struct Passage {
    Point before;
    Point at;
    Point after;

    /// True if the direction from `at` to `to` lies in the sector.
    bool holds(Point to) const noexcept {
        const int end = turn_to(before);
        const int own = turn_to(to);
        return own != end ? own < end : (own == left || own == right) && side_of(at, to, before) > 0;
    }

    /// True if the contour goes on in the direction from `at` to `to`.
    bool leads_to(Point to) const noexcept { return turn_to(to) == same; }

private:
    static constexpr int same = 0, left = 1, opposite = 2, right = 3;

    /// Which way from `after`, counter-clockwise.
    int turn_to(Point to) const noexcept {
        if (const int side = side_of(at, after, to); side != 0) {
            return side > 0 ? left : right;
        }
        return (at < after) == (at < to) ? same : opposite;
    }
};

/// True if two sectors at one point share more than a line.
inline bool solids_overlap(const Passage& a, const Passage& b) noexcept {
    return a.holds(b.after) || b.holds(a.after);
}

}  // namespace lamella
