// What every baseline shares: rounding facets to the grid, and cutting a facet by a plane. The rules are the engine's
// (lamella/grid.hpp), so equal contours are equal to the last bit.
#pragma once

#include <vector>

#include "method.hpp"

namespace lamella::baselines {

/// The soup rounded to the grid, without facets that have two equal vertices.
std::vector<Facet> quantised(const Problem& problem);

/// Whether the plane cuts the edge. The functions below require it.
inline bool is_cut(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept {
    return (a.z < plane) != (b.z < plane);
}
inline bool is_cut(const Facet& facet, std::int32_t plane) noexcept {
    return is_cut(facet[0], facet[1], plane) || is_cut(facet[1], facet[2], plane);
}

/// The point where the edge crosses the plane, interpolated from the lower vertex upwards.
Point crossing(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept;

/// The segment of a facet that the plane cuts. It starts on the edge that the facet runs down and ends on the edge that
/// it runs up.
Segment cut(const Facet& facet, std::int32_t plane) noexcept;

}  // namespace lamella::baselines
