// The slicing methods that the paper describes (2.1, 3 and 5.1).
#include <utility>

#include "geometry.hpp"
#include "methods.hpp"
#include "slice_incremental.hpp"

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

/// Every plane is tested against every triangle: O(k n). The printed text needs no correction.
SegmentLists slice_trivially(const Problem& problem) {
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

/// The layer height is constant, so z_min and z_max divided by it give the range of planes that cut the triangle. Its
/// segments are computed at once, and each is appended to the list of its plane. O(n + k + m). Built from the paper's
/// description. Planes here are rounded to the grid one by one, so the quotient is checked against its neighbours.
SegmentLists slice_by_division(const Problem& problem) {
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

/// Sorts the triangles by z_min, O(n log n), then applies the sorted case of Algorithm 2, O(n + k), and Algorithm 1.
/// slice_incremental.hpp lists what is corrected and what is kept.
SegmentLists slice_sorted(const Problem& problem) {
    const std::vector<Facet> facets = sorted_by(quantised(problem), z_min);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

/// A range ends where the next range of the same kind begins. The last ends at a sentinel.
struct SubGroup {
    std::int32_t z_max;
    std::uint32_t first_facet;
};
struct Group {
    std::int32_t z_min;
    std::uint32_t first_sub_group;
};
struct FacetTree {
    std::vector<Facet> facets;  // by z_min, then z_max
    std::vector<SubGroup> sub_groups;
    std::vector<Group> groups;
};

FacetTree grouped(const std::vector<Facet>& facets) {
    FacetTree tree;
    tree.facets = sorted_by(facets, [](const Facet& facet) { return std::pair(z_min(facet), z_max(facet)); });
    for (std::size_t t = 0; t < tree.facets.size(); ++t) {
        const std::int32_t low = z_min(tree.facets[t]);
        const std::int32_t high = z_max(tree.facets[t]);
        const bool opens_group = tree.groups.empty() || tree.groups.back().z_min != low;
        if (opens_group) {
            tree.groups.push_back({low, static_cast<std::uint32_t>(tree.sub_groups.size())});
        }
        if (opens_group || tree.sub_groups.back().z_max != high) {
            tree.sub_groups.push_back({high, static_cast<std::uint32_t>(t)});
        }
    }
    tree.groups.push_back({0, static_cast<std::uint32_t>(tree.sub_groups.size())});
    tree.sub_groups.push_back({0, static_cast<std::uint32_t>(tree.facets.size())});
    return tree;
}

std::vector<Segment> cut_at(const FacetTree& tree, std::int32_t plane) {
    std::vector<Segment> segments;
    for (std::size_t g = 0; g + 1 < tree.groups.size() && tree.groups[g].z_min < plane; ++g) {
        for (std::size_t s = tree.groups[g].first_sub_group; s < tree.groups[g + 1].first_sub_group; ++s) {
            if (tree.sub_groups[s].z_max < plane) {
                continue;
            }
            for (std::size_t t = tree.sub_groups[s].first_facet; t < tree.sub_groups[s + 1].first_facet; ++t) {
                segments.push_back(cut(tree.facets[t], plane));
            }
        }
    }
    return segments;
}

/// Triangles are sorted by z_min. Those of equal z_min form a group, and those of a group with equal z_max a sub-group.
/// A plane cuts either all triangles of a sub-group or none. O(n log n) to build. Planes are tested against sub-groups
/// instead of triangles: O(k s) for s sub-groups. Groups are in order, so the test of a plane ends at the first group
/// above it. Built from the paper's description, without the scheme's choice of layer heights, because planes are given
/// here.
SegmentLists slice_by_groups(const Problem& problem) {
    const FacetTree tree = grouped(quantised(problem));
    SegmentLists segments;
    segments.reserve(problem.planes.size());
    for (const std::int32_t plane : problem.planes) {
        segments.push_back(cut_at(tree, plane));
    }
    return segments;
}

SegmentLists slice_incrementally(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    return plane_sweep(problem.uniform ? lists_by_division(facets, problem) : lists_by_search(facets, problem), problem);
}

SegmentLists slice_presorted(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

}  // namespace

const SlicingMethod trivial_slicing{
    .name = "trivial", .source = "Chalasani and Grogan 1991; Park 2003", .slice = slice_trivially};
const SlicingMethod huang_slicing{
    .name = "Huang", .source = "Huang et al. 2012", .uniform_only = true, .slice = slice_by_division};
const SlicingMethod sort_first_slicing{
    .name = "sort-first", .source = "Minetto et al. 2017, section 3.4", .slice = slice_sorted};
const SlicingMethod tata_slicing{.name = "Tata", .source = "Tata et al. 1998", .slice = slice_by_groups};
const SlicingMethod incremental_slicing{
    .name = "incremental", .source = "Minetto et al. 2017, Algorithms 1 to 3", .slice = slice_incrementally};
const SlicingMethod presorted_slicing{
    .name = "presorted", .source = "Minetto et al. 2017, Algorithms 1 and 2", .slice = slice_presorted};

}  // namespace lamella::baselines
