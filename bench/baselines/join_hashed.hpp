// Contour-Construction as the paper prints it: Algorithm 4, timed as "Proposed" in Table 3.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O(m) expected. Contours run either way round: the algorithm forgets which end of a segment was its first.
extern const ContourMethod hashed_contours;

}  // namespace lamella::baselines
