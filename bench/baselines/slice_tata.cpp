// Triangles are sorted by z_min. Those of equal z_min form a group, and those of a group with equal z_max a sub-group.
// A plane cuts either all triangles of a sub-group or none. O(n log n) to build. Planes are tested against sub-groups
// instead of triangles: O(k s) for s sub-groups. Groups are in order, so the test of a plane ends at the first group
// above it. Built from the paper's description, without the scheme's choice of layer heights, because planes are given
// here.
#include "slice_tata.hpp"

#include <utility>

#include "facet_heights.hpp"
#include "geometry.hpp"

namespace lamella::baselines {

namespace {

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

SegmentLists slice(const Problem& problem) {
    const FacetTree tree = grouped(quantised(problem));
    SegmentLists segments;
    segments.reserve(problem.planes.size());
    for (const std::int32_t plane : problem.planes) {
        segments.push_back(cut_at(tree, plane));
    }
    return segments;
}

}  // namespace

const SlicingMethod tata_slicing{.name = "Tata", .source = "Tata et al. 1998", .slice = slice};

}  // namespace lamella::baselines
