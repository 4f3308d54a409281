// Closed rings in grid units, for tests of regions, offsets and simplification.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "lamella/grid.hpp"
#include "rings.hpp"

namespace polygons {

using lamella::Point;
using Ring = std::vector<Point>;
using Rings = std::vector<Ring>;

inline std::int32_t rounded(double v) {
    return static_cast<std::int32_t>(std::lround(v));
}

inline double between(std::mt19937& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

/// From 0 to below `count`.
inline std::int32_t below(std::mt19937& random, std::int32_t count) {
    return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(count));
}

/// Anywhere within twice `size`, but mostly near one of the points, at about `distance`, where a mistake would be.
inline rings::PlaceOf<double> place_near(std::mt19937& random, std::span<const Point> points, double size, double distance) {
    if (points.empty() || random() % 4 == 0) {
        return {between(random, -2 * size, 2 * size), between(random, -2 * size, 2 * size)};
    }
    const Point near = points[random() % points.size()];
    const double reach = distance * std::pow(10, between(random, -2, 0.3));
    return {near.x + between(random, -reach, reach), near.y + between(random, -reach, reach)};
}

inline Point at_angle(Point centre, double radius, double angle) {
    return {centre.x + rounded(radius * std::cos(angle)), centre.y + rounded(radius * std::sin(angle))};
}

inline Ring box(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

inline Ring reversed(Ring ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

inline Ring round(Point centre, double radius, int corners, double first = 0.1) {
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        ring.push_back(at_angle(centre, radius, first + 2 * std::numbers::pi * i / corners));
    }
    return ring;
}

/// Around the origin, with corners at random angles.
inline Ring star(std::mt19937& random, std::size_t corners, double least, double most) {
    std::vector<double> angles(corners);
    std::generate(angles.begin(), angles.end(), [&] { return between(random, 0, 2 * std::numbers::pi); });
    std::sort(angles.begin(), angles.end());
    Ring ring;
    for (const double angle : angles) {
        ring.push_back(at_angle({0, 0}, between(random, least, most), angle));
    }
    return ring;
}

/// Boxes with corners on a lattice, one in four a hole.
inline Rings lattice_boxes(std::mt19937& random, int count, int size, std::int32_t step) {
    Rings rings;
    for (int i = 0; i < count; ++i) {
        const std::int32_t x = below(random, size - 1);
        const std::int32_t y = below(random, size - 1);
        const auto end = [&](std::int32_t from) { return from + 1 + below(random, std::min(size - from - 1, 11)); };
        const Ring ring = box(x * step, y * step, end(x) * step, end(y) * step);
        rings.push_back(random() % 4 == 0 ? reversed(ring) : ring);
    }
    return rings;
}

/// Any points of a lattice, around the origin, one after the other.
inline Rings lattice_points(std::mt19937& random, std::size_t count, std::size_t points, int size, std::int32_t step) {
    Rings rings(count, Ring(points));
    for (Ring& ring : rings) {
        for (Point& p : ring) {
            p = {(below(random, size) - size / 2) * step, (below(random, size) - size / 2) * step};
        }
    }
    return rings;
}

/// A slab whose lower side runs in steps of any length and direction to the right.
inline Ring ragged(std::mt19937& random, double size) {
    Ring ring;
    double y = 0;
    for (double x = -size; x < size && ring.size() < 30;) {
        ring.push_back({rounded(x), rounded(y)});
        const double step = size * std::pow(10, between(random, -3, -0.4));
        const double angle = between(random, -1.5, 1.5);
        x += step * std::cos(angle);
        y += step * std::sin(angle);
    }
    ring.push_back({rounded(1.4 * size), rounded(8 * size)});
    ring.push_back({rounded(-1.4 * size), rounded(8 * size)});
    return ring;
}

}  // namespace polygons
