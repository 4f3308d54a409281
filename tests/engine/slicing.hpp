// What the engine's tests share: meshes as views, slices that are validated at once, contours as text.
#pragma once

#include <string>
#include <vector>

#include "engine/shapes.hpp"
#include "lamella/lamella.hpp"

/// A grid on which whole mm are small even numbers: x mm are 2x units, so expected contours can be written down.
inline constexpr double coarse_unit_mm = 0.5;

inline lamella::MeshView view_of(const shapes::Soup& soup) {
    return lamella::MeshView::soup(std::span<const double>(soup));
}

/// Planes at these heights, on the coarse grid: the plane at h mm is at 2h - 1 units.
lamella::SliceOptions at_heights(std::vector<double> heights_mm);

lamella::SliceOptions uniform(double layer_height_mm, double unit_mm = 0);

/// Slices. Requires success and a valid result.
lamella::SliceResult sliced(const lamella::MeshView& mesh, const lamella::SliceOptions& options);
lamella::SliceResult sliced(const shapes::Soup& soup, const lamella::SliceOptions& options);

/// Requires an error and returns it. Its message must be one line.
lamella::Error failure_of(const lamella::MeshView& mesh, const lamella::SliceOptions& options);

/// The contours of one layer, one line each:
///     outer + x8 in -: 0,0 1,0 8,0 ...      role, orientation, segments, parent, marks ("overruled", "mixed"), points
std::vector<std::string> contours_at(const lamella::SliceResult& result, std::size_t layer);
