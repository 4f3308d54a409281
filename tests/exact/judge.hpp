// Judges the engine's layers in exact arithmetic: every point is a crossing of the plane rounded to the grid, and every
// crossing is a point; contours run around each place as often as the exact segments do, but for a band of a unit along
// these. The oracle judges how contours are linked, nested, turned and measured.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/shapes.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "oracle/oracle.hpp"
#include "slicing/tuning.hpp"

namespace exact {

/// The first fault of `result` as the slices of `triangles` at its planes, in words; or empty.
std::string difference(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles);

/// Planes at up to `most` heights of vertices, and as many between the lowest and the highest vertex.
lamella::SliceOptions through_vertices(const shapes::Soup& soup, double grid_mm, std::uint64_t seed, std::size_t most);

/// Every other pair of seeds is assembled.
inline lamella::Tuning form_of(std::uint64_t seed) {
    return {.form = seed / 2 % 2 == 0 ? lamella::ContourForm::swept : lamella::ContourForm::assembled};
}

}  // namespace exact
