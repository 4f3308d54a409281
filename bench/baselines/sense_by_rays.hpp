// Finds which contours are holes (end of paper 4.2) by point-in-polygon tests, as Volpato et al. 2013 propose.
#pragma once

#include <vector>

#include "lamella/result.hpp"
#include "method.hpp"

namespace lamella::baselines {

using Roles = std::vector<std::vector<Role>>;  ///< by plane, then by polyline

/// Determines the role of each polyline. Orients outer contours counter-clockwise and holes clockwise. For c contours
/// with q points in a plane: O(c²) tests, O(c q) time.
Roles sense_by_rays(Contours& contours);

}  // namespace lamella::baselines
