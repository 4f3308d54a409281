// Solids that are given by a field rather than by rings.
#pragma once

#include <memory>

#include "models/lattice.hpp"

namespace lamella::models {

/// Torus, gyroid or bone. Leaves out detail too fine for the recipe's number of triangles.
std::unique_ptr<Field> make_field(const Recipe& recipe);

/// The bone alone; bone.cpp describes its anatomy.
std::unique_ptr<Field> make_bone(const Recipe& recipe);

}  // namespace lamella::models
