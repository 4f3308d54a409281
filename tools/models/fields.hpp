// The solids that are given by a field rather than by rings.
#pragma once

#include <memory>

#include "models/lattice.hpp"

namespace lamella::models {

/// Torus, gyroid or bone. Detail that the recipe's triangles could not carry is left out.
std::unique_ptr<Field> make_field(const Recipe& recipe);

/// The bone alone; see bone.cpp for its anatomy.
std::unique_ptr<Field> make_bone(const Recipe& recipe);

}  // namespace lamella::models
