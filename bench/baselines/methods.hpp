// All baselines: the methods that the paper describes, times or is followed by. Each source says what is corrected and kept.
#pragma once

#include <vector>

#include "lamella/result.hpp"
#include "method.hpp"

namespace lamella::baselines {

// Slicing. O() for n triangles, k planes, m segments.
extern const SlicingMethod trivial_slicing;  ///< Chalasani and Grogan 1991, timed as the slicing of Park 2003: O(k n)
extern const SlicingMethod
    tata_slicing;  ///< Tata et al. 1998, groups of facets: O(n log n + k s + m), O(n k) where all heights differ
extern const SlicingMethod huang_slicing;        ///< Huang et al. 2012, uniform planes only: O(n + k + m)
extern const SlicingMethod sort_first_slicing;   ///< the paper's second way to build its lists (3.4): O(n log n + k + m)
extern const SlicingMethod incremental_slicing;  ///< O(n + k + m) by division for uniform planes, else O(n log k + k + m)
/// The same with srt = true: O(n + k + m) for any planes. Precondition, not checked: the triangles ascend by z_min.
extern const SlicingMethod presorted_slicing;

// Contours of m segments in a plane.
extern const ContourMethod trivial_contours;  ///< paper 2.2, "Trivial" in Table 3: O(m²)
/// Algorithm 4, "Proposed" in Table 3: O(m) expected. The orientation of contours is arbitrary, because the algorithm
/// forgets the direction of segments.
extern const ContourMethod hashed_contours;
/// A sweep line (paper 2.2 and 5.2), "Park" in Table 3: O((m + p) log m) for p intersections, shared ends included. The
/// orientation of contours is arbitrary. Needs CGAL; LAMELLA_BASELINES_CGAL is defined where it is present.
extern const ContourMethod sweepline_contours;

// Both.
extern const WholeMethod slic3r_way;   ///< any planes, any mesh: O(n log n + n log k + m log m)
extern const WholeMethod mcmains;      ///< closed meshes only
extern const WholeMethod topological;  ///< TSlicer; closed meshes only
extern const WholeMethod ldni;         ///< samples; reports their number as the number of segments

inline constexpr double ldni_resolution_mm = 0.1;  ///< distance of neighbouring rays

// For look-up by name. Not inline: whether there is a sweep line differs between libraries.
constexpr const SlicingMethod* slicing_methods[] = {&trivial_slicing,    &tata_slicing,        &huang_slicing,
                                                    &sort_first_slicing, &incremental_slicing, &presorted_slicing};
constexpr const ContourMethod* contour_methods[] = {&trivial_contours, &hashed_contours,
#ifdef LAMELLA_BASELINES_CGAL
                                                    &sweepline_contours
#endif
};
constexpr const WholeMethod* whole_methods[] = {&slic3r_way, &mcmains, &topological, &ldni};

using Roles = std::vector<std::vector<Role>>;  ///< by plane, then by polyline

/// Finds which contours are holes (end of paper 4.2) by point-in-polygon tests, as Volpato et al. 2013 propose. Orients
/// outer contours counter-clockwise and holes clockwise. For c contours with q points in a plane: O(c²) tests, O(c q) time.
Roles sense_by_rays(Contours& contours);

}  // namespace lamella::baselines
