// Origins of the edges of a contour while it is rotated, turned round, joined and cut. origins[i] is of the edge from point
// i to the next one; at the end of an open polyline, of the point alone.
#pragma once

#include <algorithm>
#include <utility>

#include "lamella/result.hpp"

namespace lamella {

/// Of the edge walked the other way.
constexpr PointOrigin turned(PointOrigin origin) noexcept {
    std::swap(origin.edge, origin.end_edge);
    return origin;
}

/// Of the last point of an open polyline, by the edge that ends there.
constexpr PointOrigin end_of(const PointOrigin& last) noexcept {
    return {last.triangle, last.part, last.end_edge, no_edge};
}

/// Of a stretch of an edge: its ends are those of the whole, or are made.
constexpr PointOrigin stretch_of(PointOrigin whole, bool from_begin, bool to_end) noexcept {
    whole.edge = from_begin ? whole.edge : no_edge;
    whole.end_edge = to_end ? whole.end_edge : no_edge;
    return whole;
}

/// Of what is made of two edges: the smallest part, then the smallest triangle. An edge from none is the larger.
constexpr PointOrigin origin_of_both(const PointOrigin& a, const PointOrigin& b) noexcept {
    if (a.triangle == no_triangle || b.triangle == no_triangle) {
        return b.triangle == no_triangle ? a : b;
    }
    return a.part != b.part ? (a.part < b.part ? a : b) : std::min(a, b);
}

}  // namespace lamella
