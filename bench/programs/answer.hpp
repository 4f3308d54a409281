// Summarises a method's answer as sums of hashes. They depend neither on the order of contours nor on where each
// begins, and are small enough to be kept for every plane of the largest model.
#pragma once

#include <cstdint>
#include <vector>

#include "lamella/result.hpp"
#include "method.hpp"

namespace lamella::bench {

struct PlaneAnswer {
    std::uint64_t segments = 0;           ///< sum of hashes over all segments of non-zero length, whatever their direction
    std::vector<std::uint64_t> closed{};  ///< one hash for each closed contour's points in order; ascending
};

/// By plane.
using Answer = std::vector<PlaneAnswer>;

Answer answer_of(const SliceResult& result);
Answer answer_of(const baselines::Contours& contours);
/// The answer for segments that have not been joined.
Answer answer_of(const baselines::SegmentLists& lists);

struct Difference {
    std::uint64_t planes = 0;    ///< number of planes whose segments differ
    std::uint64_t contours = 0;  ///< number of closed contours that only one of the answers has
};

/// Precondition: both answers are for the same planes.
Difference difference(const Answer& expected, const Answer& found);

}  // namespace lamella::bench
