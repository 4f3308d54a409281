// Isosurfaces by marching tetrahedra. Every cube of a lattice is divided into the six tetrahedra around its main
// diagonal (Kuhn), which match across neighbouring cubes. Each tetrahedron contributes at most two triangles. The
// result is a closed 2-manifold for any field, because the lattice's border counts as outside.
//
// Two planes of nodes are in memory at a time. A vertex depends only on its lattice edge, so neighbours that compute it
// twice get the same bits.
#pragma once

#include <cstdint>
#include <memory>

#include "models/surface.hpp"

namespace lamella::models {

/// Nodes at (x0 + i dx, y0 + j dx, z0 + k dz) in shape space: z in [0, 1], x and y around 0.
struct Lattice {
    std::uint32_t nx = 0;
    std::uint32_t ny = 0;
    std::uint32_t nz = 0;
    double x0 = 0;
    double y0 = 0;
    double z0 = 0;
    double dx = 1;
    double dz = 1;

    double x(std::uint32_t i) const noexcept { return x0 + dx * i; }
    double y(std::uint32_t j) const noexcept { return y0 + dx * j; }
    double z(std::uint32_t k) const noexcept { return z0 + dz * k; }
    double longest_step() const noexcept { return dx > dz ? dx : dz; }
};

/// A solid: the points where the field is not negative. It lies within |x| < half_x, |y| < half_y, 0 <= z <= 1.
class Field {
public:
    Field(double x, double y) noexcept : half_x(x), half_y(y) {}
    Field(const Field&) = delete;
    Field& operator=(const Field&) = delete;
    virtual ~Field() = default;

    /// Makes the tables that fill_row() needs for this lattice.
    virtual void prepare(const Lattice& lattice) = 0;

    /// Writes the values at the inner nodes of row j of plane k, 0 < i < nx - 1. False, and none is written, where all of
    /// them are outside and next to none that is inside.
    virtual bool fill_row(std::uint32_t k, std::uint32_t j, double* row) = 0;

    const double half_x;
    const double half_y;
};

/// Torus, gyroid or bone. Leaves out detail too fine for the recipe's number of triangles.
std::unique_ptr<Field> make_field(const Recipe& recipe);

/// The bone alone; bone.cpp describes its anatomy.
std::unique_ptr<Field> make_bone(const Recipe& recipe);

/// A lattice around the field's box, with at least one extra node on each side.
Lattice lattice_around(const Field& field, double dx, double dz) noexcept;

struct SurfaceSize {
    double triangles = 0;
    double z_extent = 0;  ///< sum over triangles, in shape space
};

/// The size of march()'s result, estimated from every `stride`-th slab; exact for stride 1. Computes extents only on
/// request.
SurfaceSize measure(Field& field, const Lattice& lattice, std::uint32_t stride, bool extents);

/// Millimetres per unit of shape space.
struct Scale {
    double xy = 1;
    double z = 1;
};

/// Makes the triangles, slab by slab in ascending z. False if the consumer stopped it.
bool march(Field& field, const Lattice& lattice, Scale scale, Emitter& out);

}  // namespace lamella::models
