// Smallest and largest diameter of points: by calipers that turn around their convex hull.
//
//            q_____             width at the edge p q: how far the farthest point f lies from it. The calipers' other jaw
//           /      `.           moves on as long as points come farther. Diameters are found among pairs (p, f).
//          /         f
//         p_________/
#pragma once

#include <cstdint>
#include <span>

#include "base/worker.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Grid units.
struct Feret {
    double most = 0;
    double least = 0;
    double angle_rad = 0;  ///< of the longest; of several the smallest, in (-pi/2, pi/2]. NaN of a single point
};

/// The rings' points; their order does not matter. Preconditions: there is a point; coordinates within grid_limit.
/// O(n + h log h) for h points outside of the octagon through the extreme ones. Source: monotone chain (Andrew 1979),
/// rotating calipers (Shamos 1978).
Feret find_feret(std::span<const std::span<const Point>> rings, Worker& worker);

}  // namespace lamella
