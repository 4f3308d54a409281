// Tests of edges and points in common, by integers alone.
#pragma once

#include "lamella/grid.hpp"
#include "slicing/grid/box.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

inline bool lies_on(Point p, Point a, Point b) noexcept {
    return FlatBox::around(a, b).holds(p) && sign_of_side(a, b, p) == 0;
}

/// Whether two edges have a point in common.
inline bool have_common_point(Point a, Point b, Point c, Point d) noexcept {
    const bool cross =
        sign_of_side(a, b, c) * sign_of_side(a, b, d) < 0 && sign_of_side(c, d, a) * sign_of_side(c, d, b) < 0;
    return cross || lies_on(a, c, d) || lies_on(b, c, d) || lies_on(c, a, b) || lies_on(d, a, b);
}

/// Whether one of two edges that follow each other lies on the other.
inline bool folds_back(Point from, Point joint, Point to) noexcept {
    return lies_on(from, joint, to) || lies_on(to, from, joint);
}

/// What the edge adds to the winding number of a closed path around `p`, which does not lie on it.
inline int winding_of(Point from, Point to, Point p) noexcept {
    if ((from.y <= p.y) == (to.y <= p.y)) {
        return 0;
    }
    const int side = sign_of_side(from, to, p);
    return from.y <= p.y ? (side > 0 ? 1 : 0) : (side < 0 ? -1 : 0);
}

}  // namespace lamella
