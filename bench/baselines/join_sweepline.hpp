// Contour construction by a sweep line (paper 2.2 and 5.2): Park 2003, timed as "Park" in Table 3. Only with CGAL:
// LAMELLA_BASELINES_CGAL is defined then.
#pragma once

#include "method.hpp"

namespace lamella::baselines {

/// O((m + p) log m) for the m segments of a plane and their p intersections, common ends among them. Contours run either way
/// round.
extern const ContourMethod sweepline_contours;

}  // namespace lamella::baselines
