// Angles of directions, with the same bits on every platform: the system's atan2() differs in the last.
#pragma once

#include <cmath>

namespace lamella {

inline constexpr double pi = 0x1.921fb54442d18p+1;

/// Of 0 <= t <= 1. Two steps lead to the tangent of an angle below pi / 16, for which twelve terms of the series suffice.
inline double arctangent(double t) noexcept {
    const bool is_large = t > 0.41421356237309503;  // the tangent of pi / 8
    const double u = is_large ? (t - 1) / (t + 1) : t;
    const double v = u / (1 + std::sqrt(1 + u * u));
    const double square = v * v;
    double series = 0;
    for (int odd = 23; odd > 0; odd -= 2) {
        series = 1.0 / odd - square * series;
    }
    return (is_large ? pi / 4 : 0) + 2 * v * series;
}

/// Of the line along (x, y), which is not (0, 0): in (-pi/2, pi/2].
inline double angle_of_line(double x, double y) noexcept {
    if (x < 0 || (x == 0 && y < 0)) {
        x = -x;
        y = -y;
    }
    const double steep = std::abs(y);
    const double angle = steep <= x ? arctangent(steep / x) : pi / 2 - arctangent(x / steep);
    return y < 0 ? -angle : angle;
}

}  // namespace lamella
