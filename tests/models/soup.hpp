// What the tests ask of a generated mesh, worked out from its triangles alone.
#pragma once

#include <cstdint>
#include <vector>

#include "models/models.hpp"

namespace lamella::models::test {

/// Every directed edge, by the bits of its ends, has exactly one opposite.
bool closed_and_oriented(const std::vector<float>& soup);

/// Triangles with two vertices that fall together on the default grid.
std::uint64_t degenerate_on_default_grid(const std::vector<float>& soup);

/// Signed: positive where faces look outwards.
double volume(const std::vector<float>& soup);

/// How often a triangle crosses a plane at (i + 1/2) layer heights above zero.
std::uint64_t crossings(const std::vector<float>& soup, double layer_height_mm);

/// Lowest vertices never descend from one triangle to the next.
bool ascending(const std::vector<float>& soup);

}  // namespace lamella::models::test
