// Polygons and raw offset curves, with winding numbers and distances by brute force.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "lamella/grid.hpp"
#include "rings.hpp"
#include "slicing/offset/raw_offset.hpp"

namespace raw_offsets {

using lamella::Point;
using lamella::RawCurve;
using lamella::RawOffset;
using Ring = std::vector<Point>;

struct Curve {
    RawCurve facts;
    Ring points;
};

inline Curve offset_of(const Ring& ring, double distance, double miter_limit = 3) {
    RawOffset offset(nullptr);
    const RawCurve facts = offset.append(ring, distance, miter_limit);
    const auto points = offset.points_of(facts);
    return {facts, {points.begin(), points.end()}};
}

inline Ring reversed(Ring ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

using Place = rings::PlaceOf<double>;

inline double distance_to_edge(Place p, Point a, Point b) {
    const double dx = double(b.x) - a.x;
    const double dy = double(b.y) - a.y;
    const double along = ((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy);
    const double t = std::clamp(along, 0.0, 1.0);
    return std::hypot(a.x + t * dx - p.x, a.y + t * dy - p.y);
}

inline double distance_to(const Ring& ring, Place p) {
    double nearest = 1e300;
    rings::each_edge(ring, [&](Point a, Point b) { nearest = std::min(nearest, distance_to_edge(p, a, b)); });
    return nearest;
}

inline int winding(const Ring& ring, Place p) {
    return rings::winding(ring, p).value_or(0);
}

inline bool is_simple(const Ring& ring) {
    const std::size_t count = ring.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Point a = ring[i];
        const Point b = ring[(i + 1) % count];
        for (std::size_t j = i + 1; j < count; ++j) {
            const Point c = ring[j];
            const Point d = ring[(j + 1) % count];
            if (a == c) {
                return false;
            }
            if (j > i + 1 && (j + 1) % count != i && rings::side(a, b, c) * rings::side(a, b, d) <= 0 &&
                rings::side(c, d, a) * rings::side(c, d, b) <= 0) {
                return false;
            }
        }
    }
    return true;
}

inline bool is_counter_clockwise(const Ring& ring) {
    return rings::twice_area(ring) > 0;
}

class Polygons {
public:
    explicit Polygons(unsigned seed) : random_(seed) {}

    double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    bool coin() { return random_() % 2 == 0; }
    std::size_t below(std::size_t count) { return random_() % count; }

    Ring star(double least, double most) {
        std::vector<double> angles(3 + random_() % 12);
        std::generate(angles.begin(), angles.end(), [this] { return number(0, 6.283185307179586); });
        std::sort(angles.begin(), angles.end());
        Ring ring;
        for (const double angle : angles) {
            const double radius = number(least, most);
            ring.push_back(
                {std::int32_t(std::lround(radius * std::cos(angle))), std::int32_t(std::lround(radius * std::sin(angle)))});
        }
        return ring;
    }
    /// Corners on a lattice of 9 x 9, walked so that no two edges cross where that is found.
    Ring lattice(std::int32_t spacing) {
        Ring ring(3 + random_() % 12);
        for (Point& p : ring) {
            p = {(std::int32_t(random_() % 9) - 4) * spacing, (std::int32_t(random_() % 9) - 4) * spacing};
        }
        const std::size_t count = ring.size();
        const auto length = [&](std::size_t a, std::size_t b) {
            return std::hypot(double(ring[a].x) - ring[b % count].x, double(ring[a].y) - ring[b % count].y);
        };
        for (int round = 0; round < 40; ++round) {
            for (std::size_t i = 0; i < count; ++i) {
                for (std::size_t j = i + 2; j < count - (i == 0 ? 1 : 0); ++j) {
                    if (length(i, i + 1) + length(j, j + 1) > length(i, j) + length(i + 1, j + 1) + 1e-6) {
                        std::reverse(ring.begin() + std::ptrdiff_t(i) + 1, ring.begin() + std::ptrdiff_t(j) + 1);
                    }
                }
            }
        }
        return ring;
    }
    /// A slab whose lower side runs in steps of any length and direction to the right.
    Ring ragged(double size) {
        Ring ring;
        double y = 0;
        for (double x = -size; x < size && ring.size() < 30;) {
            ring.push_back({std::int32_t(std::lround(x)), std::int32_t(std::lround(y))});
            const double step = size * std::pow(10, number(-3, -0.4));
            const double angle = number(-1.5, 1.5);
            x += step * std::cos(angle);
            y += step * std::sin(angle);
        }
        ring.push_back({std::int32_t(1.4 * size), std::int32_t(8 * size)});
        ring.push_back({std::int32_t(-1.4 * size), std::int32_t(8 * size)});
        return ring;
    }
    /// Simple, of either orientation.
    Ring simple(double size) {
        for (;;) {
            const std::size_t kind = below(3);
            const Ring ring = kind == 0   ? star(0.2 * size, size)
                              : kind == 1 ? lattice(std::int32_t(size / 4))
                                          : ragged(size);
            if (ring.size() >= 3 && is_simple(ring)) {
                return coin() ? ring : reversed(ring);
            }
        }
    }

private:
    std::mt19937 random_;
};

}  // namespace raw_offsets
