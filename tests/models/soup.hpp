// Properties of a generated mesh, computed from its triangles alone.
#pragma once

#include <cstdint>
#include <vector>

#include "models/models.hpp"

namespace lamella::models::test {

/// Whether every directed edge, compared by the bits of its ends, has exactly one opposite.
bool closed_and_oriented(const std::vector<float>& soup);

/// Number of triangles with two vertices that are equal on the default grid.
std::uint64_t degenerate_on_default_grid(const std::vector<float>& soup);

/// Signed volume, positive if faces are oriented outwards.
double volume(const std::vector<float>& soup);

/// Number of crossings of triangles with planes at (i + 1/2) layer heights above zero.
std::uint64_t crossings(const std::vector<float>& soup, double layer_height_mm);

/// Whether lowest vertices never descend from one triangle to the next.
bool ascending(const std::vector<float>& soup);

}  // namespace lamella::models::test
