// A closed contour for nesting from its points alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/int128.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

/// Precondition: at least one point. O(points).
inline NestItem closed_item(std::span<const Point> points) noexcept {
    NestItem item;
    item.points = points.data();
    item.count = static_cast<std::uint32_t>(points.size());
    item.closed = true;
    item.box_min = item.box_max = points[0];
    Int128 twice_area = 0;
    Point before = points.back();
    for (std::uint32_t i = 0; i < item.count; ++i) {
        const Point p = points[i];
        twice_area += std::int64_t{before.x} * p.y - std::int64_t{before.y} * p.x;
        item.start = p < points[item.start] ? i : item.start;
        item.box_min.y = std::min(item.box_min.y, p.y);
        item.box_max = {std::max(item.box_max.x, p.x), std::max(item.box_max.y, p.y)};
        before = p;
    }
    item.box_min.x = points[item.start].x;
    item.twice_area = to_integer128(twice_area);
    return item;
}

}  // namespace lamella
