// lamella's contours as the host's polygons. Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <cstddef>
#include <lamella/assemble.hpp>
#include <lamella/sink.hpp>
#include <libslic3r/ExPolygon.hpp>
#include <libslic3r/Polygon.hpp>
#include <vector>

namespace Slic3r::lamella_adapter {

/// Which way loops run.
enum class Turn {
    as_facets,          ///< as the mesh's facets turn them
    counter_clockwise,  ///< all
};

/// The closed contours that have an area.
Polygons polygons(const lamella::LayerView& layer, Turn turn);

/// The same, as the library takes them.
std::vector<std::vector<lamella::Point>> loops(const lamella::LayerView& layer, Turn turn);

/// The one with the largest area, counter-clockwise; none of an empty layer.
Polygons largest_polygon(const lamella::LayerView& layer);

/// Outer contours, each with its holes.
ExPolygons expolygons(const lamella::LayerView& layer);
ExPolygons expolygons(const lamella::LayerContours& layer, double unit_mm);

}  // namespace Slic3r::lamella_adapter
