#include "slicing/regions/point_tree.hpp"

#include <algorithm>
#include <cmath>

namespace lamella {

/// In double precision, with room for its rounding: products of 33 bits and 31 have an error of less than 2^13.
bool PointTree::Edge::passes_by(const FlatBox& region) const noexcept {
    const double dx = static_cast<double>(b.x) - a.x;
    const double dy = static_cast<double>(b.y) - a.y;
    const double middle_x = (static_cast<double>(region.low.x) + region.high.x) / 2 - a.x;
    const double middle_y = (static_cast<double>(region.low.y) + region.high.y) / 2 - a.y;
    const double half_x = (static_cast<double>(region.high.x) - region.low.x) / 2 + 2;
    const double half_y = (static_cast<double>(region.high.y) - region.low.y) / 2 + 2;
    const double distance = std::abs(dx * middle_y - dy * middle_x);
    constexpr double room = 1 << 14;
    return distance > std::abs(dx) * half_y + std::abs(dy) * half_x + room;
}

void PointTree::divide(std::size_t begin, std::size_t end, StopPace& pace) {
    if (end - begin <= leaf) {
        return;
    }
    FlatBox box{nodes_[begin].point, nodes_[begin].point};
    for (std::size_t i = begin + 1; i < end; ++i) {
        const Point p = nodes_[i].point;
        box = {{std::min(box.low.x, p.x), std::min(box.low.y, p.y)}, {std::max(box.high.x, p.x), std::max(box.high.y, p.y)}};
    }
    const bool by_x = std::int64_t{box.high.x} - box.low.x >= box.height();
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) { return nodes_.begin() + static_cast<std::ptrdiff_t>(i); };
    pace.spend(4 * (end - begin));
    std::nth_element(at(begin), at(middle), at(end),
                     [by_x](const Node& a, const Node& b) { return by_x ? a.point.x < b.point.x : a.point.y < b.point.y; });
    nodes_[middle].by_x = by_x ? 1 : 0;
    divide(begin, middle, pace);
    divide(middle + 1, end, pace);
}

}  // namespace lamella
