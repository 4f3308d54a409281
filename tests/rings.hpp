// Closed rings of grid points, measured the obvious way in exact arithmetic: what tests compare the engine's answers with.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "lamella/grid.hpp"

namespace rings {

__extension__ using Int128 = __int128;
using lamella::Point;

/// Twice the area of the triangle a, b, p: above 0 where p lies left of the line from a to b.
inline Int128 cross(Point a, Point b, Point p) {
    return (Int128{b.x} - a.x) * (Int128{p.y} - a.y) - (Int128{b.y} - a.y) * (Int128{p.x} - a.x);
}

/// 1 left of the line from a to b, -1 right of it, 0 on it.
inline int side(Point a, Point b, Point p) {
    const Int128 twice = cross(a, b, p);
    return (twice > 0 ? 1 : 0) - (twice < 0 ? 1 : 0);
}

/// True if p lies on the segment from a to b.
inline bool lies_on(Point a, Point b, Point p) {
    return cross(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
           p.y <= std::max(a.y, b.y);
}

/// True if two segments have a point in common.
inline bool meet(Point a, Point b, Point c, Point d) {
    return (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) || lies_on(c, d, a) ||
           lies_on(c, d, b) || lies_on(a, b, c) || lies_on(a, b, d);
}

/// Calls take(from, to) for each edge.
template <class Take>
void each_edge(std::span<const Point> ring, const Take& take) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        take(ring[i], ring[i + 1 < ring.size() ? i + 1 : 0]);
    }
}

inline Int128 twice_area(std::span<const Point> ring) {
    Int128 sum = 0;
    each_edge(ring, [&](Point a, Point b) { sum += Int128{a.x} * b.y - Int128{a.y} * b.x; });
    return sum;
}

inline long double perimeter(std::span<const Point> ring) {
    long double sum = 0;
    each_edge(ring, [&](Point a, Point b) {
        sum += std::hypot(static_cast<long double>(b.x) - a.x, static_cast<long double>(b.y) - a.y);
    });
    return sum;
}

/// A place anywhere: its coordinates times `parts`.
template <class Number>
struct PlaceOf {
    Number x, y;
    Number parts = 1;
};
using Place = PlaceOf<Int128>;

/// How often the ring runs counter-clockwise around q; none where q lies on it.
template <class Number>
std::optional<int> winding(std::span<const Point> ring, const PlaceOf<Number>& q) {
    int number = 0;
    bool on = false;
    each_edge(ring, [&](Point from, Point to) {
        const Number ax = Number(from.x) * q.parts - q.x;
        const Number ay = Number(from.y) * q.parts - q.y;
        const Number bx = Number(to.x) * q.parts - q.x;
        const Number by = Number(to.y) * q.parts - q.y;
        const Number turn = ax * by - ay * bx;
        on = on ||
             (turn == 0 && std::min(ax, bx) <= 0 && std::max(ax, bx) >= 0 && std::min(ay, by) <= 0 && std::max(ay, by) >= 0);
        if ((ay > 0) != (by > 0)) {
            number += (by > 0 && turn > 0 ? 1 : 0) - (ay > 0 && turn < 0 ? 1 : 0);
        }
    });
    return on ? std::nullopt : std::optional(number);
}
inline std::optional<int> winding(std::span<const Point> ring, Point p) {
    return winding(ring, Place{p.x, p.y});
}

/// From p to the segment from a to b, which may be one point.
inline double distance(Point a, Point b, PlaceOf<double> p) {
    const double dx = double(b.x) - a.x;
    const double dy = double(b.y) - a.y;
    const double squared = dx * dx + dy * dy;
    const double along = squared == 0 ? 0 : std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / squared, 0.0, 1.0);
    return std::hypot(a.x + along * dx - p.x, a.y + along * dy - p.y);
}

inline bool strictly_around(std::span<const Point> ring, Point p) {
    return winding(ring, p).value_or(0) != 0;
}

/// From the smallest point on; of several such rotations the one that compares smallest. The same for each start.
inline std::vector<Point> from_smallest(const std::vector<Point>& ring) {
    std::vector<Point> best;
    const auto smallest = std::min_element(ring.begin(), ring.end());
    for (auto at = smallest; at != ring.end(); ++at) {
        if (*at == *smallest) {
            std::vector<Point> turned(at, ring.end());
            turned.insert(turned.end(), ring.begin(), at);
            best = best.empty() ? turned : std::min(best, turned);
        }
    }
    return best;
}

}  // namespace rings
