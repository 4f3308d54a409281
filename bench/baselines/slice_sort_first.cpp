// Sorts the triangles by z_min, O(n log n), then applies the sorted case of Algorithm 2, O(n + k), and Algorithm 1.
// slice_incremental.hpp lists what is corrected and what is kept.
#include "slice_sort_first.hpp"

#include "slice_incremental.hpp"

namespace lamella::baselines {

namespace {

SegmentLists slice(const Problem& problem) {
    const std::vector<Facet> facets = sorted_by(quantised(problem), z_min);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

}  // namespace

const SlicingMethod sort_first_slicing{.name = "sort-first", .source = "Minetto et al. 2017, section 3.4", .slice = slice};

}  // namespace lamella::baselines
