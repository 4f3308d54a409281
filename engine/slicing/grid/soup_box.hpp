// Boxes of a float soup and of its blocks.
#pragma once

#include <cstddef>
#include <span>

#include "base/dispatch.hpp"
#include "slicing/grid/bounds.hpp"

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

/// All forms, the fastest first.
std::span<const Form<MeasureSoup>> measure_soup_forms() noexcept;

}  // namespace lamella
