// Boxes of edges and of runs.
#pragma once

#include <algorithm>
#include <cstdint>

#include "lamella/grid.hpp"

namespace lamella {

/// An axis-parallel rectangle with its boundary.
struct FlatBox {
    Point low;
    Point high;

    static FlatBox around(Point a, Point b) noexcept {
        return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
    }
    bool meets(const FlatBox& other) const noexcept {
        return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y && other.low.y <= high.y;
    }
    FlatBox grown(std::int32_t by) const noexcept { return {{low.x - by, low.y - by}, {high.x + by, high.y + by}}; }
    std::int64_t height() const noexcept { return std::int64_t{high.y} - low.y; }
};

}  // namespace lamella
