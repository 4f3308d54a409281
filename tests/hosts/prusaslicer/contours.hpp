// lamella's contours as the host's polygons. Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <cstddef>
#include <lamella/assemble.hpp>
#include <lamella/result.hpp>
#include <libslic3r/ExPolygon.hpp>
#include <libslic3r/Polygon.hpp>
#include <span>
#include <vector>

namespace Slic3r::lamella_adapter {

/// A layer's contours where the library left them.
struct LayerView {
    std::span<const lamella::Contour> contours;
    const lamella::Point* points = nullptr;  ///< Contour::first_point counts from here
    double unit_mm = 0;

    std::span<const lamella::Point> points_of(const lamella::Contour& contour) const {
        return {points + contour.first_point, contour.point_count};
    }
};

LayerView view_of(const lamella::SliceResult& result, const lamella::Layer& layer);
LayerView view_of(const lamella::LayerContours& contours, double unit_mm);

/// Which way loops run.
enum class Turn {
    as_facets,          ///< as the mesh's facets turn them
    counter_clockwise,  ///< all
};

/// The closed contours that have an area.
Polygons polygons(const LayerView& layer, Turn turn);

/// The same, as the library takes them.
std::vector<std::vector<lamella::Point>> loops(const LayerView& layer, Turn turn);

/// The one with the largest area, counter-clockwise; none of an empty layer.
Polygons largest_polygon(const LayerView& layer);

/// Outer contours, each with its holes.
ExPolygons expolygons(const LayerView& layer);

}  // namespace Slic3r::lamella_adapter
