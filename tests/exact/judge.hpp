// Judges the engine's layers in exact arithmetic: every point is a crossing of the plane rounded to the grid, and every
// crossing is a point; contours run around each place as often as the exact segments do, but for a band of a unit along
// these. The oracle judges how contours are linked, nested, turned and measured.
//
// Judges regions by CGAL's arrangement of all edges, in exact arithmetic: the winding numbers of its faces say what is
// filled, and its half-edges what contours there must be.
//
// Where edges cross off the grid, the engine's region cannot be the exact one, and these must hold:
//
//   - The contours bound what they enclose: solid on the left, nothing covered twice, none crosses itself or another, roles
//     and parents as the arrangement of the contours themselves gives them.
//   - Every corner lies within a unit, per axis, of an input edge, and so does every point where the region differs from
//     the exact one. Points between the edges of each face that differs are tried; besides, no face may be larger than a
//     band of a unit along its own boundary, nor all of them larger than one along all input edges.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/shapes.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"
#include "oracle/oracle.hpp"
#include "regions/region.hpp"
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

/// The exact region by a rule that looks at winding numbers. Throws std::logic_error if a corner lies off the grid.
regions::Region region_on_grid(const regions::Polygons& polygons, lamella::FillRule rule);

/// The fault in the region that the engine found by the rule, even-odd, non-zero or positive; or empty.
std::string fault_in_region(const regions::Polygons& polygons, lamella::FillRule rule, const lamella::SliceResult& found);

/// The same of contours alone, without regard to roles, parents and where they part: closed, solid on the left.
std::string fault_in_rings(const regions::Polygons& polygons, lamella::FillRule rule, const regions::Polygons& rings);

}  // namespace exact
