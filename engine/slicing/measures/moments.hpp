// What Green's theorem sums over the edges of contours, exactly: integrals of 1, x, y, x^2, y^2 and xy over what is
// enclosed. Beside them the length, since a pass over the points costs as much as its sums.
//
// With k = ax by - ay bx for each edge from a to b, counter-clockwise contours add and clockwise ones subtract:
//
//     2 A       = sum k                        12 integral of x^2 = sum k (ax^2 + ax bx + bx^2)
//     6 int x   = sum k (ax + bx)              24 integral of xy  = sum k (2 ax ay + ax by + bx ay + 2 bx by)
//
// Coordinates about a point of the layer are within 2^30, so that |k| <= 2^61 and the forms fit 64 bits. Sums may wrap
// around 128 bits on the way: the whole comes out right where it fits.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Throws Refused where a layer's points are not on the grid, within which sums are right.
inline void require_on_grid(const FlatBox& box, std::uint64_t layer) {
    if (exceeds({-grid_limit, -grid_limit}, box.low) || exceeds(box.high, {grid_limit, grid_limit})) {
        throw Refused{{ErrorCode::invalid_argument, "layer " + std::to_string(layer) +
                                                        " has a point beyond the grid, which ends at " +
                                                        std::to_string(grid_limit) + " units"}};
    }
}

/// A product of two 64-bit numbers, for sums that may wrap.
inline Word128 wide_product(std::int64_t a, std::int64_t b) noexcept {
    return static_cast<Word128>(Int128{a} * Int128{b});
}

/// About a point. `twice`, `six` and so on say by how much each integral is multiplied.
struct Moments {
    Word128 twice_area = 0;
    Word128 six_x = 0;
    Word128 six_y = 0;
    Word128 twelve_xx = 0;
    Word128 twelve_yy = 0;
    Word128 twenty_four_xy = 0;
    double length = 0;

    /// Adds a closed contour of that area; without `with_second` the first three alone. Precondition: its coordinates about
    /// that point are within 2^30.
    template <bool with_second = true>
    void add(std::span<const Point> ring, const Integer128& its_twice_area, Point about) noexcept {
        Moments sum = *this;  // in registers
        sum.twice_area += static_cast<Word128>(to_int128(its_twice_area));
        const auto from_there = [about](Point p) {
            return std::pair(std::int64_t{p.x} - about.x, std::int64_t{p.y} - about.y);
        };
        auto [ax, ay] = from_there(ring.back());
        std::int64_t axx = ax * ax;
        std::int64_t ayy = ay * ay;
        std::int64_t axy = 2 * ax * ay;
        for (const Point point : ring) {
            const auto [bx, by] = from_there(point);
            const std::int64_t k = ax * by - ay * bx;
            sum.six_x += wide_product(k, ax + bx);
            sum.six_y += wide_product(k, ay + by);
            if constexpr (with_second) {
                const std::int64_t bxx = bx * bx;
                const std::int64_t byy = by * by;
                const std::int64_t bxy = 2 * bx * by;
                sum.twelve_xx += wide_product(k, axx + ax * bx + bxx);
                sum.twelve_yy += wide_product(k, ayy + ay * by + byy);
                sum.twenty_four_xy += wide_product(k, axy + ax * by + ay * bx + bxy);
                const auto dx = static_cast<double>(bx - ax);
                const auto dy = static_cast<double>(by - ay);
                sum.length += std::sqrt(dx * dx + dy * dy);
                axx = bxx;
                ayy = byy;
                axy = bxy;
            }
            ax = bx;
            ay = by;
        }
        *this = sum;
    }

    void add(const Moments& other) noexcept {
        twice_area += other.twice_area;
        six_x += other.six_x;
        six_y += other.six_y;
        twelve_xx += other.twelve_xx;
        twelve_yy += other.twelve_yy;
        twenty_four_xy += other.twenty_four_xy;
        length += other.length;
    }

    /// The same about a point (p, q) farther on.
    Moments moved(std::int64_t p, std::int64_t q) const noexcept {
        const auto p128 = static_cast<Word128>(Int128{p});
        const auto q128 = static_cast<Word128>(Int128{q});
        Moments to = *this;
        to.six_x = six_x - Word128{3} * p128 * twice_area;
        to.six_y = six_y - Word128{3} * q128 * twice_area;
        to.twelve_xx = twelve_xx - Word128{4} * p128 * six_x + Word128{6} * p128 * p128 * twice_area;
        to.twelve_yy = twelve_yy - Word128{4} * q128 * six_y + Word128{6} * q128 * q128 * twice_area;
        to.twenty_four_xy =
            twenty_four_xy - Word128{4} * p128 * six_y - Word128{4} * q128 * six_x + Word128{12} * p128 * q128 * twice_area;
        return to;
    }
};

}  // namespace lamella
