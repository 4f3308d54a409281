// Random closed meshes for the exact judge. They are oriented outwards and do not intersect themselves unless stated. Most
// have vertices, edges and faces at equal heights, where planes are then placed.
#pragma once

#include <cstdint>

#include "engine/shapes.hpp"
#include "lamella/slice.hpp"
#include "slicing/tuning.hpp"

namespace exact {

using shapes::Soup;

/// The hull of points with integer coordinates in [-range, range].
Soup hull(std::uint64_t seed, int points, std::uint64_t range);

/// Hulls that intersect, with no common coordinates; about one in three is inside out.
Soup crossing_hulls(std::uint64_t seed, int count);

/// count³ cells, each with up to four nested shells: solid, cavity, solid in the cavity, ...
Soup shells(std::uint64_t seed, int count);

/// Octahedra, 100 mm high and `width_mm` wide, that lean in random directions.
Soup needles(std::uint64_t seed, int count, double width_mm);

/// The surface of about half the cells of a cube: solids that touch along edges and at corners.
Soup cells(std::uint64_t seed, int size);

/// Planes at up to `most` heights of vertices, and as many between the lowest and the highest vertex.
lamella::SliceOptions through_vertices(const Soup& soup, double grid_mm, std::uint64_t seed, std::size_t most);

/// Every other pair of seeds is assembled.
inline lamella::Tuning form_of(std::uint64_t seed) {
    return {.form = seed / 2 % 2 == 0 ? lamella::ContourForm::swept : lamella::ContourForm::assembled};
}

}  // namespace exact
