// Compares the engine's contours with the oracle's, contour by contour.
#pragma once

#include <span>
#include <string>

#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace oracle {

/// The first difference in words, or empty. Order and starts are compared where the rules define them. They are undefined
/// where one contour, or two, pass twice through the same start on the same mesh edge.
std::string difference(const lamella::SliceResult& result, const lamella::Layer& layer, const Layer& expected);
/// The same for a result of one layer.
std::string difference(const lamella::SliceResult& result, const Layer& expected);

/// Compares every layer of `result` with the oracle's slice of `triangles` at its plane.
std::string difference(const lamella::SliceResult& result, std::span<const Triangle> triangles);

}  // namespace oracle
