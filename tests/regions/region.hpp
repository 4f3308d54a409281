// Regions as sets of contours without regard to how they are stored.
//
// Judges give what they expect as a Region. Contours are compared by their corners: points within straight lines, the point
// that a contour starts at and the order of contours do not count; roles and parents do.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "base/numbers.hpp"
#include "engine/region_checks.hpp"

namespace regions {

/// A contour with the solid on its left.
struct Ring {
    Polygon corners;
    bool hole = false;
    std::int64_t parent = -1;  ///< index into the region
    friend bool operator==(const Ring&, const Ring&) = default;
};
using Region = std::vector<Ring>;

/// The engine's region of the polygons. Throws std::runtime_error with its message where there is none.
lamella::SliceResult region_of(const Polygons& polygons, const lamella::RegionRules& rules);
lamella::SliceResult region_of(const Polygons& polygons, lamella::FillRule rule);

/// Only corners, each ring from the start that makes it smallest, rings by their corners.
Region canonical(Region region);
/// Canonical.
Region region_in(const lamella::SliceResult& contours);

/// Roles by orientation, parents by brute force. Throws std::logic_error where a ring lies on others.
void find_parents(Region& region);

/// Winding number of the whole solid is more than 0 (even-odd: odd, ...); by `outermost` as by non-zero.
bool fills(lamella::FillRule rule, std::int64_t winding);
/// The outer rings of a region by non-zero that lie in no hole.
Region without_holes(const Region& region);

Int128 twice_area(const Region& region);

/// The first difference, in words; or empty.
std::string difference(const Region& expected, const Region& found);

/// Empty if the engine returns the same bytes for the polygons in another order, from other starts, and, by a rule that does
/// not look at orientation, all of them reversed.
std::string dependence_on_order(const Polygons& polygons, const lamella::RegionRules& rules,
                                const lamella::SliceResult& found, std::mt19937& random);

/// As C++ that can be copied into a test.
std::string text_of(const Polygons& polygons);

}  // namespace regions
