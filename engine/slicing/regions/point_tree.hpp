// Points of a plane in a tree, to find those in the bounding box of an edge that lie near the edge. O(n log n) to build,
// O(sqrt n) and what is found for a query along an edge; usually O(log n).
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

class PointTree {
public:
    explicit PointTree(const Memory* memory) : points_(memory), boxes_(memory) {}

    /// Numbers points[i] i, below 2^32. Throws std::bad_alloc.
    void build(std::span<const Point> points, StopPace& pace) {
        points_.clear();
        points_.reserve(points.size());
        pace.in_stretches(0, points.size(), 4, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                points_.push_back({points[i], static_cast<std::uint32_t>(i)});
            }
        });
        const auto at = [](const Numbered& numbered) { return numbered.point; };
        order_by_place(std::span(points_), at, pace);
        const auto box_at = [this](std::size_t i) { return FlatBox{points_[i].point, points_[i].point}; };
        boxes_.assign(points_.size(), box_at, pace);
    }

    /// Calls see(point, number) for each point in the bounding box of the edge from `a` to `b`, its sides included, but for
    /// some that lie two units and more off the edge.
    template <class See>
    void find_along(Point a, Point b, See see) const {
        const FlatBox box = FlatBox::around(a, b);
        const auto enter = [&](const BoxBlock<Point>& block) {
            LaneBits met = block.meets(box);
            each_lane(met, [&](std::size_t lane) { met &= ~(LaneBits{passes_by(a, b, block[lane])} << lane); });
            return met;
        };
        boxes_.search_if(enter, [&](std::size_t i) {
            see(points_[i].point, points_[i].number);
            return true;
        });
    }

    /// Calls see(point, number) for each point in `box`, its sides included, until it returns false.
    template <class See>
    void find_in(const FlatBox& box, See see) const {
        boxes_.search_if([&](const BoxBlock<Point>& block) { return block.meets(box); },
                         [&](std::size_t i) { return see(points_[i].point, points_[i].number); });
    }

private:
    struct Numbered {
        Point point;
        std::uint32_t number;
    };

    /// True if all of `box`, with a unit around it, lies on one side of the edge from `a` to `b`. In double precision, with
    /// room for its rounding: products of 33 bits and 31 have an error of less than 2^13.
    static bool passes_by(Point a, Point b, const FlatBox& box) noexcept {
        const double dx = static_cast<double>(b.x) - a.x;
        const double dy = static_cast<double>(b.y) - a.y;
        const double middle_x = (static_cast<double>(box.low.x) + box.high.x) / 2 - a.x;
        const double middle_y = (static_cast<double>(box.low.y) + box.high.y) / 2 - a.y;
        const double half_x = static_cast<double>(width_of(box)) / 2 + 2;
        const double half_y = static_cast<double>(height_of(box)) / 2 + 2;
        const double distance = std::abs(dx * middle_y - dy * middle_x);
        constexpr double room = 1 << 14;
        return distance > std::abs(dx) * half_y + std::abs(dy) * half_x + room;
    }

    Vector<Numbered> points_;
    BoxTree<Point> boxes_;  // of points_
};

}  // namespace lamella
