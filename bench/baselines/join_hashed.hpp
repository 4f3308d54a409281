// Contour-Construction as the paper prints it: Algorithm 4, timed as "Proposed" in Table 3.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(m) expected. The orientation of contours is arbitrary, because the algorithm forgets the direction of segments.
extern const ContourMethod hashed_contours;

}  // namespace lamella::baselines
