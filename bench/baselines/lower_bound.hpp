// The paper's lower bound (3.5) as an experiment: instances of the multipoint search problem, posed as meshes, and the
// number of comparisons that Incremental-Slicing needs for them.
#pragma once

#include <cstdint>
#include <vector>

#include "methods.hpp"

namespace lamella::baselines {

/// The problem: for each of n values, which of k ascending planes is the first above it? A triangle stands for each
/// value. It begins at the value and ends just above the next plane, so the segments of the planes are the answer.
/// Planes are spaced at random.
struct SearchInstance {
    std::vector<float> soup;
    std::vector<std::int32_t> planes;
    std::vector<std::uint32_t> solution;  ///< by triangle: the index of its plane

    Problem problem() const { return {.soup = soup, .planes = planes}; }
};

/// Every answer is equally likely, so a search by comparisons needs n log2 k of them on average. The same numbers give
/// the same bytes. O(n + k). Precondition: 0 < k <= 2^22, n <= 2^22.
SearchInstance make_search_instance(std::uint32_t n, std::uint32_t k);

/// Reads the answer from the segments. By triangle: the index of its plane, or k if none cuts it.
std::vector<std::uint32_t> solution_of(const SegmentLists& segments, std::size_t n);

/// Total numbers of comparisons of two heights.
struct ComparisonCount {
    std::uint64_t search = 0;  ///< by Algorithm 3
    std::uint64_t sweep = 0;   ///< by Algorithm 1: one a segment, and one a triangle that leaves the active set
};
ComparisonCount count_comparisons(const Problem& problem);  // in slicing.cpp, beside the algorithms

}  // namespace lamella::baselines
