// The parts of validate(), by plain methods that share nothing with the slicing stages.
#pragma once

#include <string>

#include "base/numbers.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// The first broken promise in words, or empty.
using Complaint = std::string;

inline bool has_area(const Contour& contour) noexcept {
    return contour.role == Role::outer || contour.role == Role::hole;
}

/// How complaints begin.
std::string layer_place(std::size_t layer);
std::string layer_place(std::size_t layer, std::size_t contour);

/// Checks origins, as far as that can be done without the mesh. Precondition: contours lie within the points.
Complaint complaint_about_origins(const SliceResult& result);

/// Checks parents, roles and order of a layer's contours, each of which keeps its own promises.
Complaint complaint_about_nesting(const SliceResult& result, std::size_t layer);

}  // namespace lamella
