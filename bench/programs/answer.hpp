// What a method answered, as sums of hashes that depend on neither the order of contours nor where each begins: small enough
// to be kept for every plane of the largest model.
#pragma once

#include <cstdint>
#include <vector>

#include "lamella/result.hpp"
#include "method.hpp"

namespace lamella::bench {

struct PlaneAnswer {
    std::uint64_t segments = 0;           ///< sum over all segments that have a length, whichever way they run
    std::vector<std::uint64_t> closed{};  ///< each closed contour's points and their order, ascending
};

/// By plane.
using Answer = std::vector<PlaneAnswer>;

Answer answer_of(const SliceResult& result);
Answer answer_of(const baselines::Contours& contours);
/// Of segments that have not been joined.
Answer answer_of(const baselines::SegmentLists& lists);

struct Difference {
    std::uint64_t planes = 0;    ///< in which not the same segments were found
    std::uint64_t contours = 0;  ///< closed contours of either that the other has not
};

/// Precondition: answers for the same planes.
Difference difference(const Answer& expected, const Answer& found);

}  // namespace lamella::bench
