// The integer grid that everything is computed on.
//
//     const lamella::Point point = result.points[0];               // grid units
//     const double x_mm = point.x * result.info.grid_mm;                // or result.to_mm(point).x
//     const lamella::PlaneHeight plane = result.layers[0].plane;   // an odd number of grid units
//     std::printf("%g mm at height %g mm\n", x_mm, plane.z() * result.info.grid_mm);
//
// Source: section 3.1 of the paper. Vertices are rounded to even multiples of the unit and planes to odd ones, so that no
// vertex ever lies on a plane and every intersection is a proper segment. Parity is in the types: a GridVertex cannot be odd
// and a PlaneHeight cannot be even.
//
// The grid is anchored at absolute zero. Its unit is 2^-20 mm (about 1 nm) for anything within ±1,024 mm, where equal parts
// give equal bytes wherever they stand on the grid. The unit doubles beyond 1,024 mm, and parts there change with the plate:
// one that reaches farther makes the grid of all coarser.
//
// Error of each step: a vertex moves at most one unit per axis. A plane moves at most half a step of the mesh's number type
// at its height, and then at most two units: one for the grid and one for the side below or above a vertex of that very
// height. For floats, half a step is half a unit at 8 mm and 32 units (3.1e-5 mm) at 512 mm. A contour point lies at most
// half a unit (plus 2^-20 units of floating point) from the exact crossing of the rounded edge with the rounded plane.
#pragma once

#include <cassert>
#include <compare>
#include <cstdint>

namespace lamella {

/// Largest magnitude of a grid coordinate: differences of two fit 32 bits plus a sign, products of two differences 63.
inline constexpr std::int32_t grid_limit = 1 << 30;

/// The unit used when nothing else is asked for, in mm: exactly representable, and 1,024 mm = grid_limit units.
inline constexpr double default_grid_mm = 1.0 / (1 << 20);

/// Asked for as Frame::grid_mm: the finest power of two, from 2^-49 mm on, of which the mesh's farthest coordinate has at
/// most grid_limit - 2, with room for how far closing, offset and mark reach in the plane (but not in prepare(), which does
/// not know them). For meshes far smaller than a metre. Equal parts at other places may then get other grids.
inline constexpr double finest_grid = -1;

/// Inputs with a coordinate beyond this are refused.
inline constexpr double largest_coordinate_mm = 1e9;

/// A mesh vertex on the grid; every coordinate is even.
struct GridVertex {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    friend constexpr auto operator<=>(const GridVertex&, const GridVertex&) = default;
};

/// A plane's height on the grid, always odd.
class PlaneHeight {
public:
    constexpr PlaneHeight() = default;
    explicit constexpr PlaneHeight(std::int32_t odd_z) : z_(odd_z) { assert((odd_z & 1) != 0); }
    constexpr std::int32_t z() const noexcept { return z_; }
    friend constexpr auto operator<=>(PlaneHeight, PlaneHeight) = default;

private:
    std::int32_t z_ = 1;
};

/// A point of a contour, in grid units within its plane.
struct Point {
    std::int32_t x = 0;
    std::int32_t y = 0;
    friend constexpr auto operator<=>(const Point&, const Point&) = default;
};

}  // namespace lamella
