// Incremental-Slicing as the paper prints it: Algorithms 1 to 3, serial, on linked lists. Indices count from 0 here.
//
// Errors of the printed text that are corrected here:
// - Algorithm 2, uniform planes, adds 1 where it needs 2: a triangle above P[1] would be cut by P[1].
// - Its merge reads T[j] before it tests whether T[j] exists.
// - Planes are multiples of the spacing only before they are rounded to the grid: see FirstPlaneAbove.
// Kept: triangles that no plane cuts enter the active set and leave it at once. Triangles above all planes are in no
// list after the merge; otherwise they are in a list that nothing reads.
#pragma once

#include <forward_list>
#include <functional>

#include "geometry.hpp"

namespace lamella::baselines {

using TriangleList = std::forward_list<const Facet*>;
using TriangleLists = std::vector<TriangleList>;  ///< by first plane above a triangle's lowest vertex; the last list holds
                                                  ///< the triangles above all planes

/// Algorithm 3: the first plane above z_min, or the number of planes. `less` compares two heights.
template <class Less = std::less<>>
std::size_t binary_search(const std::vector<std::int32_t>& planes, std::int32_t z_min, Less less = {}) {
    if (planes.empty() || less(planes.back(), z_min)) {
        return planes.size();
    }
    std::size_t l = 0;  // counted from 1; P[0] stands for a plane below everything
    std::size_t r = planes.size();
    while (r - l > 1) {
        const std::size_t m = (l + r) / 2;
        if (less(planes[m - 1], z_min)) {
            l = m;
        } else {
            r = m;
        }
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
template <class Less = std::less<>>
TriangleLists lists_by_search(const std::vector<Facet>& facets, const Problem& problem, Less less = {}) {
    return lists_by([&](std::int32_t z) { return binary_search(problem.planes, z, less); }, facets, problem);
}

/// Algorithm 2, triangles that ascend by z_min.
TriangleLists lists_by_merge(const std::vector<Facet>& facets, const Problem& problem);

/// Algorithm 1 from step 4 on. Empties the lists.
template <class Less = std::less<>>
SegmentLists plane_sweep(TriangleLists lists, const Problem& problem, Less less = {}) {
    TriangleList active;
    SegmentLists segments(problem.planes.size());
    for (std::size_t i = 0; i < problem.planes.size(); ++i) {
        active.splice_after(active.before_begin(), lists[i]);
        auto before = active.before_begin();
        for (auto t = active.begin(); t != active.end();) {
            if (less(z_max(**t), problem.planes[i])) {
                t = active.erase_after(before);
            } else {
                segments[i].push_back(cut(**t, problem.planes[i]));
                before = t++;
            }
        }
    }
    return segments;
}

}  // namespace lamella::baselines
