// An outer contour and its holes as one ring.
//
// From the leftmost point M of each hole a bridge runs left to the nearest point B of another contour of the region, and is
// walked both ways:
//
//     .----------.
//     |   .--.   |
//     B===M  |   |        ... B M (around the hole) M B ...
//     |   '--'   |
//     '----------'
//
// A bridge meets nothing between its ends, since B is the nearest point; and two bridges never meet, since all are
// horizontal and the nearer hole would be the other's nearest. Each leads to a contour that begins farther left, so that the
// bridges form a tree with the outer contour at its root. A bridge has no area: the ring's area is the region's.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <vector>

#include "lamella/result.hpp"

namespace lamella {

/// In grid units. The end B of a bridge within an edge has no whole x.
struct RingPoint {
    double x = 0;
    double y = 0;
    friend bool operator==(const RingPoint&, const RingPoint&) = default;
};

class Keyhole {
public:
    /// `contours`: closed ones of one layer, an outer one first, then its holes, none of which crosses another; they may
    /// touch. Gives the ring, whose first point is not repeated, valid until the next call. A hole that lies in no contour
    /// is left out. h holes, q points: O(q log h) and what lies at equal heights; at most O(q h).
    std::span<const RingPoint> join(std::span<const std::span<const Point>> contours) {
        contours_ = contours;
        ring_.clear();
        start_bridges();
        for (std::uint32_t contour = 0; contour < contours.size() && !bridges_.empty(); ++contour) {
            find_ends(contour);
        }
        link_nodes();
        for (std::size_t at = 0; at != end_of_ring; at = nodes_[at].next) {
            if (ring_.empty() || !(ring_.back() == nodes_[at].point)) {
                ring_.push_back(nodes_[at].point);
            }
        }
        return ring_;
    }

private:
    /// Returns whether the direction of x lies between `to` and `from`, going counter-clockwise from the first to the
    /// second: where a contour comes from `from` to a point and goes on to `to`, the region is there.
    static bool is_right_within(Point at, Point from, Point to) {
        const auto half = [&](Point other) { return other.y > at.y || (other.y == at.y && other.x > at.x) ? 0 : 1; };
        if (half(to) != half(from)) {
            return half(to) > half(from);
        }
        const auto difference = [](std::int32_t a, std::int32_t b) { return std::int64_t{a} - b; };
        // The angle of `to` is the larger one: each product fits 63 bits.
        return difference(from.x, at.x) * difference(to.y, at.y) > difference(from.y, at.y) * difference(to.x, at.x);
    }

    static constexpr double none = -std::numeric_limits<double>::infinity();

    struct Bridge {
        std::uint32_t hole = 0;
        Point start;  ///< of the hole: M
        std::uint32_t contour = 0;
        std::uint32_t vertex = 0;  ///< where the edge begins that B lies on
        bool within = false;       ///< at a vertex: the bridge runs through the region there
        double x = none;           ///< of B
    };

    /// By the heights of holes.
    void start_bridges() {
        bridges_.clear();
        for (std::uint32_t hole = 1; hole < contours_.size(); ++hole) {
            bridges_.push_back({.hole = hole, .start = point(hole, 0)});
        }
        std::stable_sort(bridges_.begin(), bridges_.end(),
                         [](const Bridge& a, const Bridge& b) { return a.start.y < b.start.y; });
    }

    /// Offers what the edges and vertices of a contour have at the heights of bridges.
    void find_ends(std::uint32_t contour) {
        const std::size_t size = contours_[contour].size();
        for (std::uint32_t i = 0; i < size; ++i) {
            const Point a = point(contour, i);
            const Point b = point(contour, i + 1);
            auto bridge = std::lower_bound(bridges_.begin(), bridges_.end(), std::min(a.y, b.y),
                                           [](const Bridge& one, std::int32_t y) { return one.start.y < y; });
            for (; bridge != bridges_.end() && bridge->start.y <= std::max(a.y, b.y); ++bridge) {
                const std::int32_t y = bridge->start.y;
                if (y == a.y) {
                    offer(*bridge, contour, i, is_right_within(a, point(contour, i + size - 1), b), a.x);
                } else if (y != b.y) {  // there the next edge begins
                    const std::int64_t run = (std::int64_t{b.x} - a.x) * (std::int64_t{y} - a.y);
                    offer(*bridge, contour, i, false,
                          a.x + static_cast<double>(run) / static_cast<double>(std::int64_t{b.y} - a.y));
                }
            }
        }
    }

    /// Takes an end where it is nearer, and on a contour that begins farther left: contours begin at their smallest point,
    /// and the outer one is farthest left.
    void offer(Bridge& bridge, std::uint32_t contour, std::uint32_t vertex, bool within, double x) const {
        const bool begins_farther_left =
            contour == 0 || std::pair(point(contour, 0), contour) < std::pair(bridge.start, bridge.hole);
        const bool is_nearer = x > bridge.x || (x == bridge.x && within && !bridge.within);
        if (begins_farther_left && x <= bridge.start.x && is_nearer) {
            bridge = {bridge.hole, bridge.start, contour, vertex, within, x};
        }
    }

    /// Chains the points of the outer contour, and of each hole into the contour that its bridge ends on, behind the vertex
    /// before: B, the points of the hole, M again, B.
    void link_nodes() {
        std::erase_if(bridges_, [](const Bridge& bridge) { return bridge.x == none; });
        const auto distance = [&](const Bridge& bridge) {
            return std::abs(std::int64_t{bridge.start.y} - point(bridge.contour, bridge.vertex).y);
        };
        // The last one first that a walk from the vertex on meets.
        std::sort(bridges_.begin(), bridges_.end(), [&](const Bridge& a, const Bridge& b) {
            return std::tuple(a.contour, a.vertex, distance(a), a.hole) >
                   std::tuple(b.contour, b.vertex, distance(b), b.hole);
        });
        nodes_.clear();
        first_.clear();
        for (const std::span<const Point> contour : contours_) {
            first_.push_back(nodes_.size());
            for (const Point& at : contour) {
                nodes_.push_back({{static_cast<double>(at.x), static_cast<double>(at.y)}, nodes_.size() + 1});
            }
            nodes_.push_back({nodes_[first_.back()].point, end_of_ring});
        }
        nodes_[contours_[0].size() - 1].next = end_of_ring;
        for (const Bridge& bridge : bridges_) {
            const RingPoint end{bridge.x, static_cast<double>(bridge.start.y)};
            const std::size_t vertex = first_[bridge.contour] + bridge.vertex;
            nodes_[first_[bridge.hole] + contours_[bridge.hole].size()].next = nodes_.size() + 1;
            nodes_.push_back({end, first_[bridge.hole]});
            nodes_.push_back({end, nodes_[vertex].next});
            nodes_[vertex].next = nodes_.size() - 2;
        }
    }

    Point point(std::uint32_t contour, std::size_t vertex) const noexcept {
        return contours_[contour][vertex % contours_[contour].size()];
    }

    std::span<const std::span<const Point>> contours_;
    std::vector<Bridge> bridges_;  ///< of holes
    struct Node {
        RingPoint point;
        std::size_t next;
    };
    static constexpr std::size_t end_of_ring = std::numeric_limits<std::size_t>::max();
    std::vector<Node> nodes_;
    std::vector<std::size_t> first_;  ///< node of each contour; one more than it has points
    std::vector<RingPoint> ring_;
};

}  // namespace lamella
