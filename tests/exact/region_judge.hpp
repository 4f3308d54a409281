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

#include <string>

#include "exact/arrangement.hpp"

namespace exact {

/// The exact region by a rule that looks at winding numbers. Throws std::logic_error if a corner lies off the grid.
regions::Region region_on_grid(const regions::Polygons& polygons, lamella::FillRule rule);

/// The fault in the region that the engine found by the rule, even-odd, non-zero or positive; or empty.
std::string fault_in_region(const regions::Polygons& polygons, lamella::FillRule rule, const lamella::SliceResult& found);

/// The same of contours alone, without regard to roles, parents and where they part: closed, solid on the left.
std::string fault_in_rings(const regions::Polygons& polygons, lamella::FillRule rule, const regions::Polygons& rings);

/// The fault in contours that should run around each place as often as the edges do; where no edge is near.
std::string fault_in_windings(const Edges& edges, const regions::Polygons& contours);

}  // namespace exact
