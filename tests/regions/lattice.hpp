// A judge of regions without any geometry: polygons whose edges run along a lattice or at 45 degrees to it.
//
// Both diagonals of every cell cut it into four triangles, and all edges run along sides of triangles:
//
//     +-----+        The winding number of each triangle is counted edge by edge. Filled triangles that share a side are one
//     |\ N /|        solid, found by flooding. The boundary of a solid is followed from side to side; where several ends
//     | \ / |        meet, the next one clockwise.
//     |W X E|
//     | / \ |        Lattice points and the centres of cells are told by their place in half cells.
//     |/ S \|
//     +-----+
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "regions/region.hpp"

namespace regions {

class Lattice {
public:
    /// Cells in a row. The polygons' points lie on 0 to `size`.
    Lattice(const Polygons& polygons, std::int32_t size);

    /// In half cells: a lattice point (x, y) is (2 x, 2 y).
    Region region(lamella::FillRule rule) const;

private:
    std::size_t triangle(std::int32_t x, std::int32_t y, std::size_t quarter) const;
    std::vector<char> filled(lamella::FillRule rule) const;
    std::vector<std::size_t> solids(const std::vector<char>& filled) const;
    std::vector<std::size_t> beside(std::size_t triangle) const;

    std::int32_t size_;
    std::vector<std::int64_t> winding_;  // of each triangle; a margin of empty cells around
};

/// One to six polygons on 0 to `size`: closed walks at multiples of 45 degrees, triangles and rectangles, some given twice,
/// backwards, with points in straight lines, points given twice, or spikes.
Polygons random_octilinear(std::mt19937& random, std::int32_t size);

/// Where lattice points lie on the grid.
struct Placement {
    std::int32_t half_cell = 1;  ///< grid units
    Point origin;

    Point half(Point in_half_cells) const {
        return {origin.x + half_cell * in_half_cells.x, origin.y + half_cell * in_half_cells.y};
    }
    Polygons placed(const Polygons& on_lattice) const;
    Region placed(Region in_half_cells) const;
};

/// Half cells of 2 to 2^24 units, at random places. With less, rounding may move an edge to a lattice point beside it.
Placement random_placement(std::mt19937& random, std::int32_t size);

/// Judges one layer by every fill rule. Empty if all regions are right.
std::string judge_octilinear(const Polygons& on_lattice, std::int32_t size, const Placement& placement,
                             std::mt19937& random);

}  // namespace regions
