// The paper's lower bound (3.5) as an experiment: instances of the multipoint search problem, posed as meshes, and how many
// comparisons Incremental-Slicing spends on them.
#pragma once

#include <cstdint>
#include <vector>

#include "method.hpp"

namespace lamella::baselines {

/// For each of n values, which of k ascending planes is the first above it? A triangle stands for a value: it begins there
/// and reaches just above the next plane, so that the segments of a plane are the answer. Planes are spaced at random.
struct SearchInstance {
    std::vector<float> soup;
    std::vector<std::int32_t> planes;
    std::vector<std::uint32_t> solution;  ///< of each triangle, the index of its plane

    Problem problem() const;
};

/// Every answer is equally likely, so that on average no search by comparisons needs fewer than n log2 k of them. The same
/// bytes for the same seed. O(n + k). Precondition: 0 < k <= 2^22, n <= 2^30.
SearchInstance make_search_instance(std::uint32_t n, std::uint32_t k, std::uint64_t seed);

/// What the segments say of each of n triangles: the index of its plane, or k if none cuts it.
std::vector<std::uint32_t> solution_of(const SegmentLists& segments, std::size_t n);

/// Comparisons of two heights in all.
struct ComparisonCount {
    std::uint64_t search = 0;  ///< by Algorithm 3
    std::uint64_t sweep = 0;   ///< by Algorithm 1: one a segment, and one a triangle that leaves the active set
    double least = 0;          ///< n log2 k
};
ComparisonCount count_comparisons(const Problem& problem);

}  // namespace lamella::baselines
