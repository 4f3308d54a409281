// Every plane is tested against every triangle: O(k n). The printed text needs no correction.
#include "slice_trivial.hpp"

#include "geometry.hpp"

namespace lamella::baselines {

namespace {

SegmentLists slice(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    SegmentLists segments(problem.planes.size());
    for (std::size_t i = 0; i < problem.planes.size(); ++i) {
        for (const Facet& facet : facets) {
            if (is_cut(facet, problem.planes[i])) {
                segments[i].push_back(cut(facet, problem.planes[i]));
            }
        }
    }
    return segments;
}

}  // namespace

const SlicingMethod trivial_slicing{.name = "trivial", .source = "Chalasani and Grogan 1991; Park 2003", .slice = slice};

}  // namespace lamella::baselines
