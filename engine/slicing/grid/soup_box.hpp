// Boxes of a float soup and of its blocks, in the widest form that this processor has; all forms give the same.
#pragma once

#include <cstddef>

#include "slicing/grid/blocks.hpp"

namespace lamella {

struct FloatSoup {
    const std::byte* vertices;
    std::size_t stride;
    std::size_t triangle_count;
    float near_mm;
};

struct SoupBox {
    float low[3];
    float high[3];
    bool has_nan;
};

/// Blocks [begin, end), which are not empty, into `blocks`; returns the box of all of them.
using MeasureSoup = SoupBox (*)(const FloatSoup& soup, std::size_t begin, std::size_t end, TriangleBlock* blocks);

/// For the processor that this runs on.
MeasureSoup measure_soup_for_this_cpu() noexcept;
/// The portable one, for comparison.
MeasureSoup portable_measure_soup() noexcept;

}  // namespace lamella
