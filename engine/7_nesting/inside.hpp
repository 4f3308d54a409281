// Exact tests of points against edges and contours.
#pragma once

#include <cstdint>

#include "lamella/grid.hpp"

namespace lamella::nesting {

static_assert(grid_limit <= 1 << 30,
              "products of two coordinate differences must fit 63 bits, so that they compare exactly");

/// Sign of the turn a -> b -> q: +1 where q lies left of a -> b, 0 on its line, -1 right. The products are compared, never
/// subtracted: their difference could overflow.
inline int side_of(Point a, Point b, Point q) noexcept {
    const std::int64_t left = (std::int64_t{b.x} - a.x) * (std::int64_t{q.y} - a.y);
    const std::int64_t right = (std::int64_t{b.y} - a.y) * (std::int64_t{q.x} - a.x);
    return (left > right) - (left < right);
}

/// Whether the non-zero winding interior of a closed contour contains `query`; its boundary does not count as inside.
bool strictly_inside(const Point* points, std::uint32_t count, Point query) noexcept;

using InsideTest = bool (*)(const Point* points, std::uint32_t count, Point query) noexcept;

/// The fastest form of strictly_inside that this processor runs. All give the same answers.
InsideTest best_inside_test() noexcept;

}  // namespace lamella::nesting
