// The engine's contours against the oracle's, contour by contour.
#pragma once

#include <span>
#include <string>

#include "lamella/assemble.hpp"
#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace oracle {

/// The first difference in words, or empty. Order and starts are compared wherever the rules settle them: they do not
/// where a contour, or two of them, pass through the same start on the same mesh edge twice.
std::string difference(std::span<const lamella::Contour> contours, std::span<const lamella::Point> points,
                       std::int64_t first_contour, const Layer& expected);

std::string difference(const lamella::SliceResult& result, const lamella::Layer& layer, const Layer& expected);

std::string difference(const lamella::LayerContours& layer, const Layer& expected);

/// Every layer of `result` against the oracle's slice of `triangles` at its plane.
std::string difference(const lamella::SliceResult& result, std::span<const Triangle> triangles);

}  // namespace oracle
