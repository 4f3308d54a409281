// A slicer in exact arithmetic, with another algorithm and another code base than the engine. CGAL intersects every
// triangle with the plane. Segments follow each other where their exact end points are equal, whatever mesh edges those
// lie on. Nothing is rounded until the contours are complete.
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

/// A contour. Each crossing appears once. The solid is on the left according to the facets.
struct Chain {
    std::vector<Point2> points;
    bool closed = true;
};

/// The contours of the plane at odd height `z`. Where more than two segments meet, each that enters continues with the
/// next one clockwise, so that the solid lies between them. Throws std::logic_error if that one does not leave, or if two
/// have the same direction. Solids overlap there, and exact arithmetic alone cannot assign the contours.
std::vector<Chain> chains_at(std::span<const oracle::Triangle> triangles, std::int32_t z);

/// Non-zero winding; the boundary is not inside.
bool strictly_around(const Chain& chain, const Point2& p);

}  // namespace exact
