#include "medical/dicom/keyhole.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <tuple>
#include <utility>

namespace lamella {

namespace {

/// Returns whether the direction of x lies between `to` and `from`, going counter-clockwise from the first to the second:
/// where a contour comes from `from` to a point and goes on to `to`, the region is there.
bool is_right_within(Point at, Point from, Point to) {
    const auto half = [&](Point other) { return other.y > at.y || (other.y == at.y && other.x > at.x) ? 0 : 1; };
    if (half(to) != half(from)) {
        return half(to) > half(from);
    }
    const auto difference = [](std::int32_t a, std::int32_t b) { return std::int64_t{a} - b; };
    // The angle of `to` is the larger one: each product fits 63 bits.
    return difference(from.x, at.x) * difference(to.y, at.y) > difference(from.y, at.y) * difference(to.x, at.x);
}

}  // namespace

std::span<const RingPoint> Keyhole::join(std::span<const std::span<const Point>> contours) {
    contours_ = contours;
    ring_.clear();
    start_bridges();
    for (std::uint32_t contour = 0; contour < contours.size() && !bridges_.empty(); ++contour) {
        find_ends(contour);
    }
    sort_bridges();
    emit_ring();
    return ring_;
}

void Keyhole::start_bridges() {
    bridges_.clear();
    heights_.clear();
    for (std::uint32_t hole = 1; hole < contours_.size(); ++hole) {
        Bridge bridge;
        bridge.hole = hole;
        bridges_.push_back(bridge);
    }
    std::stable_sort(bridges_.begin(), bridges_.end(),
                     [&](const Bridge& a, const Bridge& b) { return point(a.hole, 0).y < point(b.hole, 0).y; });
    for (const Bridge& bridge : bridges_) {
        heights_.push_back(point(bridge.hole, 0).y);
    }
}

/// A contour begins at its smallest point. The outer one is farthest left.
bool Keyhole::begins_farther_left(std::uint32_t contour, std::uint32_t hole) const noexcept {
    return contour == 0 || std::pair(point(contour, 0), contour) < std::pair(point(hole, 0), hole);
}

/// Takes `end` where it is nearer.
void Keyhole::offer(Bridge& bridge, const Bridge& end) const {
    const Point start = point(bridge.hole, 0);
    if (!begins_farther_left(end.contour, bridge.hole) || end.whole > start.x || (end.whole == start.x && end.rest > 0)) {
        return;
    }
    if (bridge.divisor != 0) {
        const std::int64_t here = end.rest * bridge.divisor;
        const std::int64_t there = bridge.rest * end.divisor;
        if (std::tie(end.whole, here, end.within) <= std::tie(bridge.whole, there, bridge.within)) {
            return;
        }
    }
    const std::uint32_t hole = bridge.hole;
    bridge = end;
    bridge.hole = hole;
}

/// Offers what the edges and vertices of a contour have at the heights of bridges.
void Keyhole::find_ends(std::uint32_t contour) {
    const std::span<const Point> points = contours_[contour];
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point a = points[i];
        const Point b = point(contour, i + 1);
        const auto first = std::lower_bound(heights_.begin(), heights_.end(), std::min(a.y, b.y));
        const auto last = std::upper_bound(first, heights_.end(), std::max(a.y, b.y));
        for (auto height = first; height != last; ++height) {
            Bridge end;
            end.contour = contour;
            end.vertex = static_cast<std::uint32_t>(i);
            end.at_vertex = *height == a.y;
            if (*height == b.y && !end.at_vertex) {
                continue;  // the next edge begins there
            }
            if (end.at_vertex) {
                end.whole = a.x;
                end.divisor = 1;
                end.within = is_right_within(a, point(contour, i + points.size() - 1), b);
            } else {
                const std::int64_t rise = std::int64_t{b.y} - a.y;
                end.divisor = std::abs(rise);
                const std::int64_t run = (std::int64_t{b.x} - a.x) * (std::int64_t{*height} - a.y) * (rise < 0 ? -1 : 1);
                std::int64_t steps = run / end.divisor;
                steps -= run % end.divisor < 0 ? 1 : 0;
                end.whole = a.x + steps;
                end.rest = run - steps * end.divisor;
            }
            offer(bridges_[static_cast<std::size_t>(height - heights_.begin())], end);
        }
    }
}

void Keyhole::put(RingPoint point) {
    if (ring_.empty() || !(ring_.back() == point)) {
        ring_.push_back(point);
    }
}

/// In the order in which a walk around their contours meets them.
void Keyhole::sort_bridges() {
    std::erase_if(bridges_, [](const Bridge& bridge) { return bridge.divisor == 0; });
    const auto distance = [&](const Bridge& bridge) {
        return std::abs(std::int64_t{point(bridge.hole, 0).y} - point(bridge.contour, bridge.vertex).y);
    };
    std::sort(bridges_.begin(), bridges_.end(), [&](const Bridge& a, const Bridge& b) {
        return std::tuple(a.contour, a.vertex, distance(a), a.hole) < std::tuple(b.contour, b.vertex, distance(b), b.hole);
    });
    first_from_.assign(contours_.size(), static_cast<std::uint32_t>(bridges_.size()));
    for (std::size_t i = bridges_.size(); i-- > 0;) {
        first_from_[bridges_[i].contour] = static_cast<std::uint32_t>(i);
    }
}

/// Walks the outer contour, and around each hole where its bridge ends: with a stack, for holes may hang on holes.
void Keyhole::emit_ring() {
    struct Walk {
        std::uint32_t contour;
        std::size_t vertex;  ///< the next to be put
        std::size_t bridge;  ///< the next to be walked
        RingPoint back;      ///< where its own bridge ends
    };
    const auto ring_point = [](Point at) { return RingPoint{static_cast<double>(at.x), static_cast<double>(at.y)}; };
    std::vector<Walk> walks = {{0, 0, first_from_[0], {}}};
    while (!walks.empty()) {
        Walk& walk = walks.back();
        const bool due = walk.bridge < bridges_.size() && bridges_[walk.bridge].contour == walk.contour &&
                         bridges_[walk.bridge].vertex + 1 == walk.vertex;
        if (due) {
            const Bridge& bridge = bridges_[walk.bridge++];
            const RingPoint end{bridge.x(), static_cast<double>(point(bridge.hole, 0).y)};
            put(end);
            walks.push_back({bridge.hole, 0, first_from_[bridge.hole], end});
        } else if (walk.vertex < contours_[walk.contour].size()) {
            put(ring_point(point(walk.contour, walk.vertex++)));
        } else {
            const Walk done = walk;
            walks.pop_back();
            if (!walks.empty()) {
                put(ring_point(point(done.contour, 0)));
                put(done.back);
            }
        }
    }
}

}  // namespace lamella
