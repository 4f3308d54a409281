// A slicer in exact arithmetic, by another algorithm and on another code base: CGAL intersects every triangle with the
// plane, and segments follow each other where their exact end points are equal, whatever mesh edges those lie on. Nothing is
// rounded before the contours stand.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include "oracle/oracle.hpp"

namespace exact {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point2 = Kernel::Point_2;

/// A contour: each crossing once, with the solid on the left as the facets say.
struct Chain {
    std::vector<Point2> points;
    bool closed = true;
};

/// The contours of the plane at odd height `z`. Where more than two segments meet, each that comes in goes on with the next
/// one clockwise, so that the solid lies between them. Throws std::logic_error where that one does not go out, or two have
/// the same direction: solids overlap there, and exact arithmetic alone does not say which contour is whose.
std::vector<Chain> chains_at(std::span<const oracle::Triangle> triangles, std::int32_t z);

/// Non-zero winding; the boundary is not inside.
bool strictly_around(const Chain& chain, const Point2& p);

}  // namespace exact
