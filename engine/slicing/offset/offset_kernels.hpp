// The loops over every edge and corner of a contour that is offset, in forms for several instruction sets. All forms give
// the same bytes: the same operations in the same order, without contraction.
#pragma once

#include <cstddef>
#include <span>

#include "base/dispatch.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// 1 + cos theta of a turn whose miter is 1,000 distances long. The miters of sharper corners are not computed: too few
/// digits of them would be right.
inline constexpr double sharpest_cosine1 = 2e-6;

/// Edge i runs from corner i to corner i + 1 and stands at i + 1; the last one stands at 0 too.
struct OffsetEdges {
    double* ux;  ///< unit direction
    double* uy;
    double* length;
};

struct OffsetCorners {
    double* added;    ///< to the length of both moved edges; negative at an inner corner
    double* cosine1;  ///< 1 + the cosine of the turn
    Point* miter;
};

struct OffsetKernels {
    /// count + 1 edges. Precondition: consecutive points differ.
    void (*edges)(const Point* points, std::size_t count, const OffsetEdges& edges);
    /// `count` corners, as if none passed the limit. Returns the least 1 + cos theta.
    double (*corners)(const Point* points, std::size_t count, const OffsetEdges& edges, double distance,
                      const OffsetCorners& corners);
};

/// Ordered as best_of() expects.
std::span<const Form<OffsetKernels>> offset_kernel_forms() noexcept;

/// The nearest point of the grid; beyond it, the nearest of those just outside.
Point rounded_to_grid(double x, double y) noexcept;

}  // namespace lamella
