// A closed contour for nesting from its points alone.
#pragma once

#include <cstdint>
#include <span>

#include "base/numbers.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/nesting/ring_facts.hpp"

namespace lamella {

/// Precondition: at least one point. `origins`: of each point, or null. O(points).
inline NestItem closed_item(std::span<const Point> points, const PointOrigin* origins = nullptr) noexcept {
    const RingFacts facts = examine_ring(points.data(), points.size());
    NestItem item;
    item.points = points.data();
    item.origins = origins;
    item.count = static_cast<std::uint32_t>(points.size());
    item.start = static_cast<std::uint32_t>(facts.smallest);
    item.twice_area = to_integer128(facts.twice_area);
    item.box_min = facts.box_min;
    item.box_max = facts.box_max;
    item.closed = true;
    return item;
}

}  // namespace lamella
