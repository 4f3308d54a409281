// Judges the engine's layers in exact arithmetic: every point is a crossing of the plane rounded to the grid, and every
// crossing is a point; contours run around each place as often as the exact segments do, but for a band of a unit along
// these. The oracle judges how contours are linked, nested, turned and measured.
#pragma once

#include <span>
#include <string>

#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace exact {

/// The first fault of `result` as the slices of `triangles` at its planes, in words; or empty.
std::string difference(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles);

}  // namespace exact
