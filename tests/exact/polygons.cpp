#include "exact/polygons.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace exact {

using regions::Point;
using regions::Polygon;
using regions::Polygons;

namespace {

std::int64_t draw(std::mt19937& random, std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
}

bool one_in(std::mt19937& random, unsigned times) {
    return random() % times == 0;
}

/// Where polygons lie: within `reach` of the centre, and never off the grid.
struct Area {
    std::int64_t reach;
    std::int64_t centre_x, centre_y;

    Point point(std::int64_t dx, std::int64_t dy) const {
        const auto within = [](std::int64_t value) {
            return static_cast<std::int32_t>(std::clamp<std::int64_t>(value, -lamella::grid_limit, lamella::grid_limit));
        };
        return {within(centre_x + dx), within(centre_y + dy)};
    }
    Point random_point(std::mt19937& random) const {
        return point(draw(random, -reach, reach), draw(random, -reach, reach));
    }
};

Area random_area(std::mt19937& random, std::size_t points) {
    // Few units only for few points: a lattice full of edges is all crossings.
    constexpr std::array<std::int64_t, 6> reaches{4, 12, 100, 10'000, 1 << 20, lamella::grid_limit};
    const std::size_t first = points > 100 ? 3 : (points > 20 ? 1 : 0);
    const std::int64_t reach = reaches[first + random() % (reaches.size() - first)];
    const std::int64_t room = lamella::grid_limit - reach;
    return {reach, draw(random, -room, room), draw(random, -room, room)};
}

Polygon anywhere(std::mt19937& random, const Area& area, std::size_t points) {
    Polygon polygon(points);
    std::generate(polygon.begin(), polygon.end(), [&] { return area.random_point(random); });
    return polygon;
}

/// Steps of about a circle's circumference through `points`, so that few of them cross.
Polygon walk(std::mt19937& random, const Area& area, std::size_t points) {
    const std::int64_t step = std::max<std::int64_t>(2, 4 * area.reach / static_cast<std::int64_t>(points));
    Polygon polygon;
    for (std::size_t i = 0; i < points; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(points);
        const double radius = static_cast<double>(area.reach) * 0.8;
        polygon.push_back(area.point(static_cast<std::int64_t>(radius * std::cos(angle)) + draw(random, -step, step),
                                     static_cast<std::int64_t>(radius * std::sin(angle)) + draw(random, -step, step)));
    }
    return polygon;
}

/// Every point the same way round from the one before it: edges cross in rings.
Polygon star(std::mt19937& random, const Area& area, std::size_t points) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(draw(random, 1, 4)) / static_cast<double>(points);
    Polygon polygon;
    for (std::size_t i = 0; i < points; ++i) {
        const double radius = static_cast<double>(area.reach) * (i % 2 == 0 ? 1.0 : 0.5);
        const double angle = turn * static_cast<double>(i);
        polygon.push_back(area.point(static_cast<std::int64_t>(radius * std::cos(angle)),
                                     static_cast<std::int64_t>(radius * std::sin(angle))));
    }
    return polygon;
}

Polygon rectangle(std::mt19937& random, const Area& area) {
    const Point a = area.random_point(random);
    const Point b = area.random_point(random);
    return {a, {b.x, a.y}, b, {a.x, b.y}};
}

Polygon moved(std::mt19937& random, Polygon polygon) {
    const auto by = [&] { return static_cast<std::int32_t>(draw(random, -2, 2)); };
    const Point all{by(), by()};
    for (Point& point : polygon) {
        point = {std::clamp(point.x + all.x, -lamella::grid_limit, lamella::grid_limit),
                 std::clamp(point.y + all.y, -lamella::grid_limit, lamella::grid_limit)};
    }
    return polygon;
}

Polygon random_polygon(std::mt19937& random, const Area& area, std::size_t points) {
    if (points > 150) {  // anywhere: their crossings would grow with the square
        return one_in(random, 2) ? walk(random, area, points) : star(random, area, points);
    }
    switch (random() % 8) {
        case 0:
            return rectangle(random, area);
        case 1:
            return star(random, area, points);
        case 2:
        case 3:
            return walk(random, area, points);
        default:
            return anywhere(random, area, points);
    }
}

/// Another polygon, or one of those before, which then share their edges or lie close to each other.
template <class Make>
Polygons several(std::mt19937& random, std::int64_t most, const Make& make) {
    Polygons polygons;
    for (std::int64_t count = draw(random, 1, most); count > 0; --count) {
        if (polygons.empty() || !one_in(random, 4)) {
            polygons.push_back(make());
        } else {
            polygons.push_back(polygons[random() % polygons.size()]);
        }
        if (one_in(random, 3)) {
            std::reverse(polygons.back().begin(), polygons.back().end());
        }
    }
    return polygons;
}

}  // namespace

Polygons random_polygons(std::mt19937& random, std::size_t points) {
    const Area area = random_area(random, points);
    const std::int64_t most = points > 400 ? 1 : 4;
    const std::size_t each = std::max<std::size_t>(3, points / static_cast<std::size_t>((most + 1) / 2));
    Polygons polygons = several(random, most, [&] { return random_polygon(random, area, each); });
    if (one_in(random, 4)) {
        polygons.push_back(moved(random, polygons[random() % polygons.size()]));
    }
    return polygons;
}

Polygons random_on_small_lattice(std::mt19937& random) {
    const auto on_lattice = [&] { return static_cast<std::int32_t>(draw(random, 0, 3)) * cell; };
    return several(random, 4, [&] {
        Polygon polygon(static_cast<std::size_t>(draw(random, 3, 9)));
        std::generate(polygon.begin(), polygon.end(), [&] { return Point{on_lattice(), on_lattice()}; });
        return polygon;
    });
}

}  // namespace exact
