// The layer height is constant, so z_min and z_max divided by it give the range of planes that cut the triangle. Its
// segments are computed at once, and each is appended to the list of its plane. O(n + k + m). Built from the paper's
// description. Planes here are rounded to the grid one by one, so the quotient is checked against its neighbours.
#include "slice_huang.hpp"

#include "facet_heights.hpp"
#include "first_plane.hpp"
#include "geometry.hpp"

namespace lamella::baselines {

namespace {

SegmentLists slice(const Problem& problem) {
    const FirstPlaneAbove first_above(problem);
    SegmentLists segments(problem.planes.size());
    for (const Facet& facet : quantised(problem)) {
        const std::size_t end = first_above(z_max(facet));
        for (std::size_t i = first_above(z_min(facet)); i < end; ++i) {
            segments[i].push_back(cut(facet, problem.planes[i]));
        }
    }
    return segments;
}

}  // namespace

const SlicingMethod huang_slicing{.name = "Huang", .source = "Huang et al. 2012", .uniform_only = true, .slice = slice};

}  // namespace lamella::baselines
