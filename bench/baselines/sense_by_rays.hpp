// Which contours are holes (paper 4.2, at its end): point-in-polygon tests, as Volpato et al. 2013 propose.
#pragma once

#include <vector>

#include "lamella/result.hpp"
#include "method.hpp"

namespace lamella::baselines {

using Roles = std::vector<std::vector<Role>>;  ///< of each plane's polylines

/// Tells the role of each polyline and turns outer contours counter-clockwise and holes clockwise. For c contours of q
/// points in a plane, O(c²) tests, O(c q) time.
Roles sense_by_rays(Contours& contours);

}  // namespace lamella::baselines
