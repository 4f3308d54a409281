// The slicing methods that the paper describes (2.1, 3 and 5.1).
//
// Incremental-Slicing is as the paper prints it: Algorithms 1 to 3, serial, on linked lists. Indices count from 0 here.
//
// Errors of the printed text that are corrected here:
// - Algorithm 2, uniform planes, adds 1 where it needs 2: a triangle above P[1] would be cut by P[1].
// - Its merge reads T[j] before it tests whether T[j] exists.
// - Planes are multiples of the spacing only before they are rounded to the grid: see FirstPlaneAbove.
// Kept: triangles that no plane cuts enter the active set and leave it at once. Triangles above all planes are in no
// list after the merge; otherwise they are in a list that nothing reads.
#include <forward_list>
#include <limits>
#include <utility>

#include "geometry.hpp"
#include "methods.hpp"

namespace lamella::baselines {

namespace {

using TriangleList = std::forward_list<const Facet*>;
using TriangleLists = std::vector<TriangleList>;  ///< by first plane above a triangle's lowest vertex; the last list holds
                                                  ///< the triangles above all planes

/// Algorithm 3: the first plane above z_min, or the number of planes.
std::size_t binary_search(const std::vector<std::int32_t>& planes, std::int32_t z_min) {
    if (planes.empty() || planes.back() < z_min) {
        return planes.size();
    }
    std::size_t l = 0;  // counted from 1; P[0] stands for a plane below everything
    std::size_t r = planes.size();
    while (r - l > 1) {
        const std::size_t m = (l + r) / 2;
        (planes[m - 1] < z_min ? l : r) = m;
    }
    return r - 1;
}

/// Algorithm 2. first_above(z) is the first plane above a height: by division for uniform planes, else by search.
template <class FirstAbove>
TriangleLists lists_by(const FirstAbove& first_above, const std::vector<Facet>& facets, const Problem& problem) {
    TriangleLists lists(problem.planes.size() + 1);
    for (const Facet& facet : facets) {
        lists[first_above(z_min(facet))].push_front(&facet);
    }
    return lists;
}

/// Algorithm 2, triangles that ascend by z_min.
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

/// Algorithm 1 from step 4 on. Empties the lists.
SegmentLists plane_sweep(TriangleLists lists, const Problem& problem) {
    TriangleList active;
    SegmentLists segments(problem.planes.size());
    for (std::size_t i = 0; i < problem.planes.size(); ++i) {
        active.splice_after(active.before_begin(), lists[i]);
        auto before = active.before_begin();
        for (auto t = active.begin(); t != active.end();) {
            if (z_max(**t) < problem.planes[i]) {
                t = active.erase_after(before);
            } else {
                segments[i].push_back(cut(**t, problem.planes[i]));
                before = t++;
            }
        }
    }
    return segments;
}

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
SegmentLists slice_sorted(const Problem& problem) {
    const std::vector<Facet> facets = sorted_by(quantised(problem), z_min);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

/// Facets whose lowest and highest vertices lie equally high. A plane cuts either all of them or none.
struct SubGroup {
    std::int32_t z_min;
    std::int32_t z_max;
    std::size_t first_facet;
};

/// Triangles are sorted by z_min and z_max, O(n log n), and those of equal heights form a sub-group. Planes are tested
/// against sub-groups instead of triangles: O(k s) for s sub-groups. They ascend, so the test of a plane ends at the first
/// one above it. Built from the paper's description, without the scheme's choice of layer heights, because planes are given
/// here.
SegmentLists slice_by_groups(const Problem& problem) {
    const std::vector<Facet> facets =
        sorted_by(quantised(problem), [](const Facet& facet) { return std::pair(z_min(facet), z_max(facet)); });
    std::vector<SubGroup> groups;
    for (std::size_t t = 0; t < facets.size(); ++t) {
        const auto [low, high] = std::pair(z_min(facets[t]), z_max(facets[t]));
        if (groups.empty() || groups.back().z_min != low || groups.back().z_max != high) {
            groups.push_back({low, high, t});
        }
    }
    groups.push_back({std::numeric_limits<std::int32_t>::max(), 0, facets.size()});
    SegmentLists segments(problem.planes.size());
    for (std::size_t i = 0; i < segments.size(); ++i) {
        const std::int32_t plane = problem.planes[i];
        for (std::size_t g = 0; groups[g].z_min < plane; ++g) {
            for (std::size_t t = groups[g].first_facet; groups[g].z_max > plane && t < groups[g + 1].first_facet; ++t) {
                segments[i].push_back(cut(facets[t], plane));
            }
        }
    }
    return segments;
}

SegmentLists slice_incrementally(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    const auto search = [&](std::int32_t z) { return binary_search(problem.planes, z); };
    return plane_sweep(
        problem.uniform ? lists_by(FirstPlaneAbove(problem), facets, problem) : lists_by(search, facets, problem), problem);
}

SegmentLists slice_presorted(const Problem& problem) {
    const std::vector<Facet> facets = quantised(problem);
    return plane_sweep(lists_by_merge(facets, problem), problem);
}

}  // namespace

const SlicingMethod trivial_slicing{.name = "trivial", .slice = slice_trivially};
const SlicingMethod huang_slicing{.name = "Huang", .uniform_only = true, .slice = slice_by_division};
const SlicingMethod sort_first_slicing{.name = "sort-first", .slice = slice_sorted};
const SlicingMethod tata_slicing{.name = "Tata", .slice = slice_by_groups};
const SlicingMethod incremental_slicing{.name = "incremental", .slice = slice_incrementally};
const SlicingMethod presorted_slicing{.name = "presorted", .slice = slice_presorted};

}  // namespace lamella::baselines
