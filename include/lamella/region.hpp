// Regions: what is solid where contours overlap, closed over narrow gaps, grown or shrunk.
//
//     // Two squares that overlap become one contour of eight points.
//     const lamella::Point low[] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
//     const lamella::Point high[] = {{2, 2}, {6, 2}, {6, 6}, {2, 6}};
//     const std::span<const lamella::Point> squares[] = {low, high};
//     lamella::RegionRules rules;
//     rules.fill_rule = lamella::FillRule::non_zero;
//     const lamella::Result<lamella::LayerContours> region = lamella::region_of(squares, rules);
//
// slice() does the same to every layer by SliceOptions::region. The steps, in this order; each is left out where it is not
// asked for:
//
//     fill rule      contours that meet are cut where they cross; what bounds the region is kept
//     closing        dilated by close_mm, then eroded by as much: gaps under twice close_mm are filled
//     offset         dilated by offset_mm, or eroded where it is negative
//     outermost      holes, and what lies in them, go
//     largest_only   all but the outer contour of the largest area, with its holes, go
//     drop_collinear points within straight lines go
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

/// What is solid where contours overlap, nest in the same direction or run backwards. All rules but the first change
/// contours: one that meets no other is kept as it is, or dropped; those that meet are cut, and the points where they cross
/// are rounded to the grid. Every point of the region lies within a unit per axis of a point of the exact one, and the two
/// differ only within a unit of the contours' edges.
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
    std::uint64_t first_layer = 0;  ///< index into SliceResult::layers
    FillRule rule = FillRule::contours;
};

/// What is done to the closed contours of a layer. Open polylines are left as they are.
struct RegionRules {
    FillRule fill_rule = FillRule::contours;
    std::vector<FillFrom> fill_from;  ///< by first_layer, ascending
    bool largest_only = false;
    double close_mm = 0;       ///< not negative
    double offset_mm = 0;      ///< negative: eroded
    double miter_limit = 3;    ///< corners whose offset would lie farther than so many offsets are cut off; at least 1
    double mark_near_mm = 0;   ///< contours that closing by so much would change get the flag near_contour; nothing else is done
    bool drop_collinear = false;

    FillRule rule_of(std::uint64_t layer) const noexcept;
    /// Whether every layer keeps its contours as the mesh gives them.
    bool keeps_contours() const noexcept;
};

/// The region that closed contours bound, with outers and holes, parents, and in the order of SliceResult. A contour's last
/// point leads to its first; equal consecutive points count once. `unit_mm` is what a grid unit of the points is.
///
/// O((m + c) log (m + c)) for m points and c places where edges come within two units of one another. It works on the
/// calling thread, and takes memory from `control`. Errors: invalid_argument (a point beyond grid_limit, more than 2^30
/// points, a rule that is out of range, an offset beyond the grid), out_of_memory, cancelled.
Result<LayerContours> region_of(std::span<const std::span<const Point>> contours, const RegionRules& rules,
                                double unit_mm = default_unit_mm, const Control& control = {}) noexcept;

}  // namespace lamella
