// The meshes of the golden cases: nothing but integers divided by a power of two, so that no compiler, C library or number
// type can change them. Each fits 24 bits, so that float and double hold the same mesh.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "engine/shapes.hpp"
#include "lamella/slice.hpp"
#include "models/numbers.hpp"

namespace golden {

using shapes::Soup;

/// The mesh of that name, in mm.
Soup mesh(const std::string& name);

std::vector<std::string> mesh_names();

/// One mesh of triangles, quads and larger polygons in every format, by file name. Large enough to be parsed by several
/// tasks.
std::map<std::string, std::string> mesh_files();

/// From low to high, both possible.
inline int between(lamella::models::Random& random, int low, int high) noexcept {
    return low + static_cast<int>(random.next() % static_cast<std::uint64_t>(high - low + 1));
}

}  // namespace golden

/// The meshes and plans that the tests of determinism share with the golden cases that are named after shapes.
namespace shape_cases {

/// Closed ones, open ones, crossing ones, and one with faces of all kinds at its edges.
std::map<std::string, shapes::Soup> meshes();

/// By name: uniform, irregular, and at random heights that this mesh gets by a seed.
std::map<std::string, lamella::SliceOptions> plans(const shapes::Soup& mesh);

}  // namespace shape_cases
