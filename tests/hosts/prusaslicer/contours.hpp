// The library's contours as the host's polygons. Part of the adapter, under its licence: AGPL-3.0-or-later (see
// adapter.cpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <lamella/grid.hpp>
#include <lamella/layers.hpp>
#include <lamella/result.hpp>
#include <libslic3r/ExPolygon.hpp>
#include <libslic3r/Polygon.hpp>
#include <span>
#include <vector>

namespace Slic3r::lamella_adapter {

using lamella::Contour;
using lamella::Role;

// Two 32-bit numbers, x first, in both: points in the host's unit are copied as bytes.
static_assert(sizeof(Point) == sizeof(lamella::Point) && sizeof(coord_t) == sizeof(std::int32_t));

/// Which way loops run.
enum class Turn {
    as_facets,          ///< as the mesh's facets turn them
    counter_clockwise,  ///< all
};

inline bool is_loop(const Contour& contour) {
    return contour.role == Role::outer || contour.role == Role::hole;
}

inline Points host_points(const lamella::LayerView& layer, const Contour& contour) {
    const std::span<const lamella::Point> from = layer.points_of(contour);
    const auto host_units = static_cast<coord_t>(layer.grid_mm / lamella::default_grid_mm);
    if (host_units == 1) {
        const Point* first = reinterpret_cast<const Point*>(from.data());
        return Points(first, first + from.size());
    }
    Points points;
    points.reserve(from.size());
    for (const lamella::Point& point : from) {
        points.emplace_back(point.x * host_units, point.y * host_units);
    }
    return points;
}

inline Polygon polygon(const lamella::LayerView& layer, const Contour& contour) {
    Polygon made;
    made.points = host_points(layer, contour);
    return made;
}

// Whether the library's points run the other way: the sense of an inverted shell is that of its role, not of its facets.
inline bool is_reversed(const Contour& contour, Turn turn) {
    const int runs = contour.role == Role::outer ? 1 : -1;
    return turn == Turn::counter_clockwise ? runs < 0 : runs != contour.orientation;
}

/// The closed contours that have an area.
inline Polygons polygons(const lamella::LayerView& layer, Turn turn) {
    Polygons made;
    made.reserve(layer.contours.size());
    for (const Contour& contour : layer.contours) {
        if (is_loop(contour)) {
            made.emplace_back(polygon(layer, contour));
            if (is_reversed(contour, turn)) {
                made.back().reverse();
            }
        }
    }
    return made;
}

/// The same, as the library takes them.
inline std::vector<std::vector<lamella::Point>> loops(const lamella::LayerView& layer, Turn turn) {
    std::vector<std::vector<lamella::Point>> made;
    for (const Contour& contour : layer.contours) {
        if (is_loop(contour)) {
            const std::span<const lamella::Point> points = layer.points_of(contour);
            std::vector<lamella::Point>& loop = made.emplace_back(points.begin(), points.end());
            if (is_reversed(contour, turn)) {
                std::reverse(loop.begin(), loop.end());
            }
        }
    }
    return made;
}

/// The one with the largest area, counter-clockwise; none of an empty layer.
inline Polygons largest_polygon(const lamella::LayerView& layer) {
    const auto area = [](const Contour& contour) { return is_loop(contour) ? std::abs(contour.twice_area.to_double()) : 0; };
    const auto largest =
        std::max_element(layer.contours.begin(), layer.contours.end(),
                         [&](const Contour& left, const Contour& right) { return area(left) < area(right); });
    if (largest == layer.contours.end() || !is_loop(*largest)) {
        return {};
    }
    Polygons made;
    made.emplace_back(polygon(layer, *largest));
    made.back().make_counter_clockwise();
    return made;
}

inline ExPolygon expolygon(const lamella::LayerView& layer, const lamella::Island& island) {
    ExPolygon whole;
    whole.contour = polygon(layer, *island.outer);
    whole.holes.reserve(island.holes.size());
    for (const Contour& hole : island.holes) {
        whole.holes.emplace_back(polygon(layer, hole));
    }
    return whole;
}

/// Outer contours, each with its holes.
inline ExPolygons expolygons(const lamella::LayerView& layer) {
    const lamella::Islands islands = layer.islands();
    ExPolygons made;
    made.reserve(static_cast<std::size_t>(std::distance(islands.begin(), islands.end())));
    for (const lamella::Island island : islands) {
        made.emplace_back(expolygon(layer, island));
    }
    return made;
}

}  // namespace Slic3r::lamella_adapter
