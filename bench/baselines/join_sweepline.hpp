// Contour construction by a sweep line (paper 2.2 and 5.2): Park 2003, timed as "Park" in Table 3. Needs CGAL;
// LAMELLA_BASELINES_CGAL is defined where it is present.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O((m + p) log m) for m segments in a plane and their p intersections, shared ends included. The orientation of
/// contours is arbitrary.
extern const ContourMethod sweepline_contours;

}  // namespace lamella::baselines
