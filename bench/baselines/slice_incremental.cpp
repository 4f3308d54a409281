// Minetto et al. 2017, section 3. The header lists what is corrected and what is kept.
#include "slice_incremental.hpp"

#include "first_plane.hpp"

namespace lamella::baselines {

TriangleLists lists_by_division(const std::vector<Facet>& facets, const Problem& problem) {
    const FirstPlaneAbove first_above(problem);
    TriangleLists lists(problem.planes.size() + 1);
    for (const Facet& facet : facets) {
        lists[first_above(z_min(facet))].push_front(&facet);
    }
    return lists;
}

TriangleLists lists_by_merge(const std::vector<Facet>& facets, const Problem& problem) {
    TriangleLists lists(problem.planes.size() + 1);
    std::size_t j = 0;
    for (std::size_t i = 0; i < problem.planes.size(); ++i) {
        while (j < facets.size() && z_min(facets[j]) < problem.planes[i]) {
            lists[i].push_front(&facets[j]);
            ++j;
        }
    }
    return lists;
}

namespace {

SegmentLists slice(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    return plane_sweep(problem.uniform ? lists_by_division(facets, problem) : lists_by_search(facets, problem), problem);
}

SegmentLists slice_presorted(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

}  // namespace

const SlicingMethod incremental_slicing{
    .name = "incremental", .source = "Minetto et al. 2017, Algorithms 1 to 3", .slice = slice};
const SlicingMethod presorted_slicing{
    .name = "presorted", .source = "Minetto et al. 2017, Algorithms 1 and 2", .slice = slice_presorted};

}  // namespace lamella::baselines
