// The meshes and plans that the tests of determinism share with the golden cases that are named after shapes.
#pragma once

#include <map>
#include <string>

#include "engine/shapes.hpp"
#include "lamella/slice.hpp"

namespace shape_cases {

/// Closed ones, open ones, crossing ones, and one with faces of all kinds at its edges.
std::map<std::string, shapes::Soup> meshes();

/// By name: uniform, irregular, and at random heights that this mesh gets by a seed.
std::map<std::string, lamella::SliceOptions> plans(const shapes::Soup& mesh);

}  // namespace shape_cases
