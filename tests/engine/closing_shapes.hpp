// Polygons in grid units, for tests of regions.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "lamella/grid.hpp"

namespace shapes2d {

using lamella::Point;
using Ring = std::vector<Point>;
using Rings = std::vector<Ring>;

inline std::int32_t rounded(double v) {
    return static_cast<std::int32_t>(std::lround(v));
}

inline Ring box(std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

inline Ring turned(Ring ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

inline Ring round(std::int32_t x, std::int32_t y, double radius, int corners, double first = 0.1) {
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        const double angle = first + 2 * std::numbers::pi * i / corners;
        ring.push_back({x + rounded(radius * std::cos(angle)), y + rounded(radius * std::sin(angle))});
    }
    return ring;
}

/// A back of the given height with teeth upwards.
inline Ring comb(int teeth, std::int32_t width, std::int32_t gap, std::int32_t height) {
    const std::int32_t right = teeth * width + (teeth - 1) * gap;
    Ring ring = {{0, 0}, {right, 0}};
    for (int i = teeth - 1; i >= 0; --i) {
        const std::int32_t x = i * (width + gap);
        ring.push_back({x + width, 2 * height});
        ring.push_back({x, 2 * height});
        if (i > 0) {
            ring.push_back({x, height});
            ring.push_back({x - gap, height});
        }
    }
    return ring;
}

/// Star-shaped around the origin, with radii between a tenth and all of `most`.
inline Ring random_star(std::mt19937& random, int corners, double most) {
    std::uniform_real_distribution<double> part(0.1, 1);
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners;
        const double length = most * part(random);
        ring.push_back({rounded(length * std::cos(angle)), rounded(length * std::sin(angle))});
    }
    return ring;
}

/// Boxes with corners on a lattice, one in four a hole.
inline Rings random_boxes(std::mt19937& random, int count, int size, std::int32_t step) {
    const auto draw = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low));
    };
    Rings rings;
    for (int i = 0; i < count; ++i) {
        const int x = draw(0, size - 1);
        const int y = draw(0, size - 1);
        Ring ring =
            box(x * step, y * step, draw(x + 1, std::min(size, x + 12)) * step, draw(y + 1, std::min(size, y + 12)) * step);
        rings.push_back(random() % 4 == 0 ? turned(ring) : ring);
    }
    return rings;
}

/// Any points of a lattice, around the origin, one after the other.
inline Rings random_lattice(std::mt19937& random, int count, int points, int size, std::int32_t step) {
    Rings rings;
    for (int i = 0; i < count; ++i) {
        Ring& ring = rings.emplace_back();
        for (int p = 0; p < points; ++p) {
            const auto draw = [&] {
                return (static_cast<std::int32_t>(random() % static_cast<unsigned>(size)) - size / 2) * step;
            };
            const std::int32_t x = draw();
            ring.push_back({x, draw()});
        }
    }
    return rings;
}

struct Named {
    std::string name;
    Rings rings;
};

/// Layers whose gaps are around twice `r` wide, one grid unit more and less, or thinner than that.
inline std::vector<Named> layers_to_close(double r) {
    std::vector<Named> layers;
    const auto u = [r](double times) { return rounded(times * r); };
    const auto ring = [u](std::initializer_list<std::array<double, 2>> corners) {
        Ring scaled;
        for (const auto& [x, y] : corners) {
            scaled.push_back({u(x), u(y)});
        }
        return scaled;
    };
    for (const int over : {-1, 0, 1}) {
        const std::int32_t gap = rounded(2 * r) + over;
        const std::string by = " with gaps of 2 r " + std::string(over < 0 ? "- 1" : over > 0 ? "+ 1" : "");
        layers.push_back({"a comb" + by, {comb(9, u(3), gap, u(10))}});
        Rings circles;
        for (double radius = 60 * r; radius > 6 * r; radius -= 3 * r + gap) {
            circles.push_back(round(0, 0, radius, 64));
            circles.push_back(turned(round(0, 0, radius - 3 * r, 64)));
        }
        layers.push_back({"concentric rings" + by, circles});
        Rings thin;
        for (double radius = 60 * r; radius > 6 * r; radius -= gap + 0.1 * r) {
            thin.push_back(round(0, 0, radius, 96));
            thin.push_back(turned(round(0, 0, radius - 0.1 * r, 96)));
        }
        layers.push_back({"thin concentric rings" + by, thin});
        layers.push_back(
            {"circles side by side" + by,
             {round(0, 0, 20 * r, 50, 0), round(u(40) + gap, 0, 20 * r, 50, 0), round(u(20), u(60), 20 * r, 37, 0.2)}});
        layers.push_back({"a slanting slit" + by,
                          {{{0, 0}, {u(80), u(31)}, {u(80), u(60)}, {0, u(29)}},
                           {{gap, -gap}, {u(80), u(31) - 2 * gap}, {u(80), u(-20)}, {gap, u(-60)}}}});
        layers.push_back({"bodies inside a hole" + by,
                          {round(0, 0, 60 * r, 60), turned(round(0, 0, 40 * r, 60)), box(u(-10), u(-10), u(10), u(10)),
                           box(u(10) + gap, u(-5), u(20), u(5)), box(u(-25), u(-5), u(-10) - gap, u(5))}});
    }
    Rings needles;
    for (int i = 0; i < 12; ++i) {
        const double angle = 0.05 + 2 * std::numbers::pi * i / 12;
        const double at = angle + 0.02;
        needles.push_back({{u(3 * std::cos(angle)), u(3 * std::sin(angle))},
                           {u(90 * std::cos(at)), u(90 * std::sin(at))},
                           {u(3.2 * std::cos(angle + 0.3)), u(3.2 * std::sin(angle + 0.3))}});
    }
    layers.push_back({"needles", needles});
    layers.push_back({"one needle", {ring({{0, 0}, {100, 0.5}, {0, 1}})}});
    layers.push_back(
        {"a slit like a needle", {ring({{0, 0}, {100, 0}, {100, 49.5}, {10, 50}, {100, 50.5}, {100, 100}, {0, 100}})}});
    layers.push_back({"touching bodies",
                      {box(0, 0, u(20), u(20)), box(u(20), u(20), u(40), u(40)), box(u(20), u(-10), u(40), u(10)),
                       ring({{60, 0}, {80, 20}, {60, 40}, {40, 20}})}});
    layers.push_back(
        {"overlapping bodies", {round(0, 0, 30 * r, 40), round(u(50), u(3), 30 * r, 41), box(u(-5), u(-50), u(5), u(50))}});
    layers.push_back({"an inverted shell", {turned(comb(5, u(3), u(1.5), u(10))), turned(round(u(70), 0, 20 * r, 30))}});
    layers.push_back({"inverted around upright", {turned(round(0, 0, 60 * r, 60)), round(0, 0, 30 * r, 60)}});
    Ring steps = {{0, 0}, {u(60), 0}};
    for (int i = 12; i > 0; --i) {  // a slope of steps under the radius
        steps.push_back({u(5.0 * i), u(20) + u(0.3) * i});
        steps.push_back({u(5.0 * i) - u(0.4), u(20) + u(0.3) * i});
    }
    steps.push_back({0, u(20)});
    layers.push_back({"steps with short edges", {steps}});
    layers.push_back({"a notch with a short floor",
                      {ring({{0, 0}, {60, 0}, {60, 40}, {31, 40}, {30.3, 20}, {29.9, 20}, {28, 40}, {0, 40}})}});
    layers.push_back(
        {"a shallow notch", {ring({{0, 0}, {60, 0}, {60, 40}, {31.5, 40}, {31.5, 39}, {28.5, 39}, {28.5, 40}, {0, 40}})}});
    layers.push_back({"rounded by short edges",
                      {round(0, 0, 20 * r, 400), turned(round(0, 0, 1.5 * r, 200)), turned(round(u(10), 0, 0.9 * r, 100))}});
    return layers;
}

}  // namespace shapes2d
