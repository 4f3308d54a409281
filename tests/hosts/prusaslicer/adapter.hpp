// The host's lengths, meshes, heights, transforms and exceptions as the library takes them, and the library's contours as
// the host's polygons. Part of the adapter, under its licence: AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <lamella/grid.hpp>
#include <lamella/layers.hpp>
#include <lamella/slice.hpp>
#include <libslic3r/ExPolygon.hpp>
#include <libslic3r/Polygon.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <libslic3r/TriangleMeshSlicer.hpp>
#include <vector>

namespace Slic3r::lamella_adapter {

/// The library works in a frame of its own: 2^20 of the host's units of 1e-6 mm are what it calls a millimetre, so that its
/// default unit, 2^-20 mm, is the host's unit. A mesh too large for that gets a larger power of two by itself. In this frame
/// the library reads floats fastest.
inline constexpr float frame_per_mm = 15625.0F / 16384;
static_assert(frame_per_mm * 0x1p20 == 1e6 && lamella::default_grid_mm == 0x1p-20);

/// Rounds to float, as the host does where it scales a coordinate.
constexpr float in_frame(float mm) {
    return mm * frame_per_mm;
}

/// Called by several threads at once; may throw.
using TakeLayer = std::function<void(const lamella::LayerView& layer)>;

/// Cuts a mesh at the host's heights, in any order, and hands over the layers, each as soon as it is finished. Returns the
/// layer of each height. Throws what `take` and the host's cancelling throw, and SlicingError where the library refuses the
/// mesh.
std::vector<std::uint64_t> cut(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                               const Transform3d& transform, const lamella::RegionRules& rules,
                               const std::function<void()>& throw_on_cancel, const TakeLayer& take);

/// At one height, on the calling thread.
void cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform, const TakeLayer& take);

/// Projects faces onto layers at the host's heights: a result for each of `faces`. Throws as cut().
std::vector<lamella::SliceResult> project(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                                          const Transform3d& transform, const std::vector<lamella::LayerContent>& faces,
                                          const std::function<void()>& throw_on_cancel);

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

}  // namespace Slic3r::lamella_adapter
