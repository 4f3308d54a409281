// The naive contour construction (paper 2.2), timed as "Trivial" in Table 3.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(m²) for m segments in a plane.
extern const ContourMethod trivial_contours;

}  // namespace lamella::baselines
