// What every baseline does alike: facets rounded to the grid, and a facet cut by a plane. The rules are the engine's (see
// lamella/grid.hpp), so that equal contours are equal to the last bit.
#pragma once

#include <vector>

#include "method.hpp"

namespace lamella::baselines {

/// The soup on the grid, without the facets that have two equal vertices.
std::vector<Facet> quantised(const Problem& problem);

/// Whether the plane cuts the edge. Precondition for all that follows.
inline bool is_cut(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept {
    return (a.z < plane) != (b.z < plane);
}
inline bool is_cut(const Facet& facet, std::int32_t plane) noexcept {
    return is_cut(facet[0], facet[1], plane) || is_cut(facet[1], facet[2], plane);
}

/// The point of an edge at the plane, interpolated from the lower vertex up.
Point crossing(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept;

/// Of a facet that the plane cuts: it enters by the edge that the facet runs down, and leaves by the one that it runs up.
Segment cut(const Facet& facet, std::int32_t plane) noexcept;

}  // namespace lamella::baselines
