// The algorithms that the paper describes or compares, behind one interface: a triangle soup and planes in, contours
// out. They serve only for measurements. They share the engine's grid and rounding, so that answers can be compared.
//
// A slicing method gives a list of segments for each plane. A contour method joins such lists. Any slicing method can
// be combined with any contour method. A whole method does both steps in its own way and passes more than segments
// between them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lamella/grid.hpp"
#include "lamella/result.hpp"

namespace lamella::baselines {

using Facet = std::array<GridVertex, 3>;

/// The solid lies on its left.
struct Segment {
    Point from;
    Point to;
};
using SegmentLists = std::vector<std::vector<Segment>>;  ///< one list for each plane

struct Polyline {
    std::vector<Point> points;  ///< a closed polyline does not repeat its first point
    bool closed = false;
};
using Contours = std::vector<std::vector<Polyline>>;  ///< by plane; contours in any order, from any start point

struct Problem {
    std::span<const float> soup;       ///< mm, nine numbers a triangle
    double unit_mm = default_grid_mm;  ///< grid unit
    std::vector<std::int32_t> planes;  ///< grid units, odd, ascending
    bool uniform = false;              ///< whether plane i lies within a quarter of a step of first + i * step
    double first = 0;                  ///< grid units; for uniform planes only
    double step = 0;                   ///< grid units; for uniform planes only

    std::size_t facets() const noexcept { return soup.size() / 9; }
};

struct SlicingMethod {
    std::string_view name;
    bool uniform_only = false;
    SegmentLists (*slice)(const Problem&) = nullptr;
};

struct ContourMethod {
    std::string_view name;
    std::vector<Polyline> (*join_plane)(const std::vector<Segment>&) = nullptr;

    /// Joins the segments plane by plane.
    Contours join(const SegmentLists& lists) const {
        Contours contours;
        contours.reserve(lists.size());
        for (const std::vector<Segment>& segments : lists) {
            contours.push_back(join_plane(segments));
        }
        return contours;
    }
};

struct WholeOutcome {
    Contours contours;
    std::uint64_t segments = 0;
    double slicing_s = 0;  ///< time up to the first step that joins segments; 0 where the two steps cannot be separated
};

struct WholeMethod {
    std::string_view name;
    WholeOutcome (*run)(const Problem&) = nullptr;
};

// All methods: those that the paper describes, times or is followed by. Each source says what is corrected and kept.

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

// For look-up by name. Not inline: whether there is a sweep line differs between libraries.
constexpr const SlicingMethod* slicing_methods[] = {&trivial_slicing,    &tata_slicing,        &huang_slicing,
                                                    &sort_first_slicing, &incremental_slicing, &presorted_slicing};
constexpr const ContourMethod* contour_methods[] = {&trivial_contours, &hashed_contours,
#ifdef LAMELLA_BASELINES_CGAL
                                                    &sweepline_contours
#endif
};
constexpr const WholeMethod* whole_methods[] = {&slic3r_way, &mcmains, &topological};

using Roles = std::vector<std::vector<Role>>;  ///< by plane, then by polyline

/// Finds which contours are holes (end of paper 4.2) by point-in-polygon tests, as Volpato et al. 2013 propose. Orients
/// outer contours counter-clockwise and holes clockwise. For c contours with q points in a plane: O(c²) tests, O(c q) time.
Roles sense_by_rays(Contours& contours);

}  // namespace lamella::baselines
