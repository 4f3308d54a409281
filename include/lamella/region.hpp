// Regions: what is solid where contours overlap, closed over narrow gaps, grown or shrunk.
//
//     // Two squares that overlap become one contour of eight points.
//     const lamella::Point low[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
//     const lamella::Point high[] = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
//     const std::span<const lamella::Point> squares[] = {low, high};
//     lamella::RegionRules rules;
//     rules.fill_rule = lamella::FillRule::non_zero;
//     const lamella::Result<lamella::LayerContours> region = lamella::region_of(squares, rules, 0.5);  // mm a grid unit
//     if (region) {
//         std::printf("%zu points, %g mm2\n", region->points.size(), region->area_mm2());
//     }
//
// slice() does the same to every layer by SliceOptions::region. The steps follow in this order; each is left out where it is
// not asked for:
//
//     fill rule      contours that meet are cut where they cross; what bounds the region is kept
//     closing        dilated by close_mm, then eroded by as much: gaps under twice close_mm are filled
//     offset         dilated by offset_mm, or eroded where it is negative
//     outermost      holes, and what lies in them, go
//     largest_only   all but the outer contour of the largest area, with its holes, go
//     drop_collinear points within straight lines go
//     simplify_mm    points within so much of the lines that replace them go
//     mark_near_mm   contours that closing would change now are marked
//
// The contours of a region have their solid on the left and cross nowhere, but may touch in points. Solid does not hang
// together by a point, what is empty does:
//
//     .---.            .-----------.
//     |   |            | .--.      |
//     '---o---.        | |  |      |
//         |   |        | '--o--.   |
//         '---'        |    |  |   |
//                      |    '--'   |
//                      '-----------'
//     two outers       an outer, and one hole, which passes `o` twice
//
// A hole that touches the contour around it is no hole: the outer passes that point twice.
//
// A given contour that no step changes stays as it is: points, start, Contour::segments and the flags gap_closed and
// orientation_mixed. One that was made, of one or several, starts at its smallest (x, y); its `segments` are its edges, its
// flags are empty but for near_contour, and its `part` is that of all its edges or several_parts. No contour of a region is
// orientation_overruled: the rule decides roles. Layer::segments counts triangles, whatever the rules make of them.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/grid.hpp"

namespace lamella {

struct LayerContours;

/// What is solid where contours overlap, nest in the same direction or run backwards. A point's winding number is how many
/// times contours run counter-clockwise around it. All rules but the first change contours: one that meets no other is kept
/// as it is, or dropped; those that meet are cut, and the points where they cross are rounded to the grid. Every point of
/// the region lies within a unit per axis of a point of the exact one, and the two differ only within a unit of the
/// contours' edges. The bytes do not depend on the order of contours, their starts, threads or the platform.
enum class FillRule : std::uint8_t {
    contours,   ///< the contours as the mesh gives them: nothing is joined or cut
    even_odd,   ///< solid within an odd number of contours
    non_zero,   ///< solid where the winding number is not 0
    positive,   ///< solid where the winding number, by the facets' orientation, is more than 0
    outermost,  ///< as non_zero, without holes
};

/// "contours", "even-odd", "non-zero", "positive" or "outermost".
std::string_view name_of(FillRule rule) noexcept;

/// From this layer on another rule.
struct FillFrom {
    std::uint64_t first_layer = 0;  ///< among those of the plan
    FillRule rule = FillRule::contours;
};

/// What is done to the closed contours of a layer. Open polylines bound nothing: they are left as they are, and
/// SliceSummary::open_contours counts them. Layers of which nothing is left are empty; SliceSummary::emptied_layers counts
/// them. Closing, offset, largest_only and drop_collinear need a rule other than `contours` in every layer.
///
/// Lengths are 0, which does nothing, or at least a grid unit. Edges are moved one by one, with miter joins. What they may
/// reach must lie on the grid: the farthest coordinate plus max(2, miter_limit) times the larger of close_mm + |offset_mm|
/// and mark_near_mm is at most grid_limit units. What cannot be done is invalid_argument before anything is cut.
struct RegionRules {
    FillRule fill_rule = FillRule::contours;
    std::vector<FillFrom> fill_from;  ///< by first_layer, ascending
    bool largest_only = false;        ///< of equal areas the one that starts first
    double close_mm = 0;              ///< not negative; contours that closing would give back are not touched
    double offset_mm = 0;             ///< negative: eroded, and what is thinner than twice that vanishes
    double miter_limit = 3;  ///< corners whose offset would lie farther than so many offsets are cut off; at least 1
    /// Contours that closing by so much would change get the flag near_contour, and nothing else is done; any rule will do.
    /// A contour is marked where its offset by so much meets itself or the offset of another contour (closer than twice so
    /// much, by miters from farther), turns an edge round (a hole or notch that is narrower, a short edge between two inner
    /// corners), or passes the miter limit at an inner corner (a sharp notch). Closing gives back those without the flag to
    /// the unit.
    double mark_near_mm = 0;
    bool drop_collinear = false;  ///< only points exactly on the line between their neighbours
    /// Points go that lie within so much, in whole grid units, of the line that replaces them and their neighbours that go;
    /// the line lies as near to the contour that was. Any rule will do; open polylines are simplified too. Starts, ends of
    /// polylines, three points of a closed contour and the sign of its area stay; contours without area stay whole. No line
    /// crosses or touches another edge, or passes a contour by on the other side: where it would, and where contours met
    /// before, points stay. Contour::segments stays too, but for contours that were made, whose edges it counts. Layers stay
    /// whole where edges come near one another so often that to compare them would take more than O(m log m) for m points.
    double simplify_mm = 0;

    FillRule rule_of(std::uint64_t layer) const noexcept;
    /// Whether every layer keeps its contours as the mesh gives them, but for simplify_mm.
    bool keeps_contours() const noexcept;
    /// Whether nothing at all is done.
    bool leaves_contours() const noexcept { return keeps_contours() && simplify_mm == 0 && mark_near_mm == 0; }
};

/// The region that closed contours bound, with outers and holes, parents, and in the order of SliceResult. A contour's last
/// point leads to its first; equal consecutive points count once. `unit_mm` is what a grid unit of the points is.
///
/// O((m + c) log (m + c)) for m points and c places where edges come within two units of one another; memory O(m + c). It
/// works on the calling thread; of `control` it uses `memory`, for the result and all scratch, and `stop`. Errors:
/// invalid_argument (negative threads, a unit that is not finite and above 0, a rule that is out of range, a point beyond
/// grid_limit, offsets that may reach beyond it, more than 2^30 points), out_of_memory, cancelled.
Result<LayerContours> region_of(std::span<const std::span<const Point>> contours, const RegionRules& rules,
                                double unit_mm = default_unit_mm, const Control& control = {}) noexcept;

}  // namespace lamella
