#include "region_patterns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace lamella::bench {

namespace {

constexpr std::int32_t step = 10'000;  // grid units, 0.01 mm

Point rounded(double x, double y) {
    return {static_cast<std::int32_t>(std::lround(x)), static_cast<std::int32_t>(std::lround(y))};
}

Point at_angle(double radius, double angle) {
    return rounded(radius * std::cos(angle), radius * std::sin(angle));
}

std::vector<Point> box(Point low, Point high) {
    return {low, {high.x, low.y}, high, {low.x, high.y}};
}

std::int32_t side_of_square(double count) {
    return static_cast<std::int32_t>(std::lround(std::sqrt(count)));
}

/// Squares that touch in corners: every second one of a board.
Pattern checkerboard(double share) {
    Pattern pattern{"checkerboard_100000", step / 8, {}};
    const std::int32_t side = side_of_square(200'000 * share);
    for (std::int32_t i = 0; i < side * side; ++i) {
        if ((i / side + i % side) % 2 == 0) {
            const Point low{i % side * step, i / side * step};
            pattern.contours.push_back(box(low, {low.x + step, low.y + step}));
        }
    }
    return pattern;
}

/// Squares apart from one another.
Pattern squares(double share) {
    Pattern pattern{"squares_apart_40000", step / 8, {}};
    const std::int32_t side = side_of_square(40'000 * share);
    for (std::int32_t i = 0; i < side * side; ++i) {
        const Point low{i % side * step, i / side * step};
        pattern.contours.push_back(box(low, {low.x + step / 2, low.y + step / 2}));
    }
    return pattern;
}

/// One in another, every second a hole, turned by `angle`.
Pattern nested(const char* name, double count, double angle) {
    Pattern pattern{name, step / 8, {}};
    for (std::int32_t i = 0; i < count; ++i) {
        std::vector<Point>& ring = pattern.contours.emplace_back();
        for (int corner = 0; corner < 4; ++corner) {
            ring.push_back(at_angle((count - i) * step, angle + corner * std::numbers::pi / 2));
        }
        if (i % 2 == 1) {
            std::reverse(ring.begin(), ring.end());
        }
    }
    return pattern;
}
Pattern nested_squares(double share) {
    return nested("nested_1000", 1'000 * share, std::numbers::pi / 4);
}
Pattern nested_turned(double share) {
    return nested("nested_1000_turned", 1'000 * share, 0);
}

/// One strip, half as wide as its turns are apart.
Pattern spiral(double share) {
    Pattern pattern{"spiral_30000", step / 8, {{}}};
    const int count = static_cast<int>(15'000 * share);
    const auto at = [](int i, double out) {
        const double angle = std::sqrt(2.0 * i * 20);  // points about as far apart everywhere
        return at_angle(step * (angle / (2 * std::numbers::pi) + 1 + out), angle);
    };
    for (int i = 0; i < count; ++i) {
        pattern.contours[0].push_back(at(i, 0.5));
    }
    for (int i = count; i-- > 0;) {
        pattern.contours[0].push_back(at(i, 0));
    }
    return pattern;
}

/// Lines along x and as many along y, half as wide as the gaps between them: two bars cross in four points.
Pattern net(double share) {
    Pattern pattern{"net_200", step / 8, {}};
    const auto count = static_cast<std::int32_t>(100 * std::sqrt(share));
    for (std::int32_t i = 0; i < count; ++i) {
        pattern.contours.push_back(box({-step, i * step}, {count * step, i * step + step / 3}));
        pattern.contours.push_back(box({i * step, -step}, {i * step + step / 3, count * step}));
    }
    return pattern;
}

/// Stars of as many points as there are stars, which overlap.
Pattern stars(double share) {
    Pattern pattern{"stars_300x300", step / 8, {}};
    const auto count = static_cast<int>(300 * std::sqrt(share));
    std::mt19937 random(1);
    std::uniform_real_distribution<double> part(0, 1);
    const double size = 100.0 * step;
    for (int i = 0; i < count; ++i) {
        const double x = part(random) * size * std::sqrt(count);
        const double y = part(random) * size * std::sqrt(count);
        std::vector<Point>& ring = pattern.contours.emplace_back();
        for (int p = 0; p < count; ++p) {
            const double angle = 2 * std::numbers::pi * p / count;
            const double radius = size * (0.5 + 0.5 * part(random));
            ring.push_back(rounded(x + radius * std::cos(angle), y + radius * std::sin(angle)));
        }
    }
    return pattern;
}

/// A screw's section of small facets: threads of 0.5 mm, edges of 2.5 um.
Pattern screw(double share) {
    Pattern pattern{"screw_50000", 400'000, {{}}};
    const int count = static_cast<int>(50'000 * share);
    for (int i = 0; i < count; ++i) {
        const double turn = static_cast<double>(i) / count;
        const double thread = std::abs(std::fmod(turn * 24, 1.0) - 0.5);
        pattern.contours[0].push_back(at_angle(20e6 * share + 1e6 * share * thread, 2 * std::numbers::pi * turn));
    }
    return pattern;
}

/// A rough ring of edges of 1.8 um, to be offset by 500 of them.
Pattern wide(double share) {
    Pattern pattern{"wide_2500", static_cast<std::int32_t>(900'000 * share), {{}}};
    std::mt19937 random(2);
    const int count = static_cast<int>(2'500 * share);
    for (int i = 0; i < count; ++i) {
        const double radius =
            1'800.0 * count / (2 * std::numbers::pi) + std::uniform_real_distribution<double>(0, 600)(random);
        pattern.contours[0].push_back(at_angle(radius, 2 * std::numbers::pi * i / count));
    }
    return pattern;
}

}  // namespace

std::vector<Pattern (*)(double)> list_patterns() {
    return {checkerboard, squares, nested_squares, nested_turned, spiral, net, stars, screw, wide};
}

}  // namespace lamella::bench
