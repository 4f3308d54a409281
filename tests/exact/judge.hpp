// Compares the engine's layers with exact ones: the same contours, roles and nesting; every point is the exact crossing
// rounded to the grid; areas and perimeters are as close as that rounding allows.
#pragma once

#include <span>
#include <string>

#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace exact {

/// The first difference between `result` and the exact slices of `triangles` at its planes, in words; or empty.
std::string difference(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles);

}  // namespace exact
