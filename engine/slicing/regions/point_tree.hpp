// Points of a plane in a tree, to find those in the bounding box of an edge that lie near the edge. The points are halved by
// x or by y, whichever they spread more in, then each half, and so on. The point that divides a range stands in its middle:
//
//       0   1   2   3   4   5   6
//     [ p | p | p | p | p | p | p ]      3 divides all by x: what stands before it is not right of it
//       `---------'   `---------'        1 divides the first half by y, 5 the second by x or y
//
// O(n log n) to build, O(sqrt n) and what is found for a query along an edge; usually O(log n).
#pragma once

#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/edges/flat_box.hpp"

namespace lamella {

class PointTree {
public:
    explicit PointTree(const Memory* memory) : nodes_(memory) {}

    /// Numbers points[i] i, below 2^31. Throws std::bad_alloc.
    void build(std::span<const Point> points, StopPace& pace) {
        nodes_.clear();
        nodes_.reserve(points.size());
        pace.in_stretches(0, points.size(), 4, [&](std::size_t first, std::size_t last) {
            for (auto i = static_cast<std::uint32_t>(first); i < last; ++i) {
                nodes_.push_back({points[i], i & 0x7fffffff, 0});
            }
        });
        divide(0, nodes_.size(), pace);
    }

    /// Calls see(point, number) for each point in the bounding box of the edge from `a` to `b`, its sides included, but for
    /// some that lie two units and more off the edge.
    template <class See>
    void find_along(Point a, Point b, See see) const {
        const Edge edge{a, b, FlatBox::around(a, b)};
        constexpr Point least{-(grid_limit + 2), -(grid_limit + 2)};
        constexpr Point most{grid_limit + 2, grid_limit + 2};
        find(0, nodes_.size(), {least, most}, edge, see);
    }

    /// Calls see(point, number) for each point in `box`, its sides included, until it returns false.
    template <class See>
    void find_in(const FlatBox& box, See see) const {
        find_in(0, nodes_.size(), box, see);
    }

private:
    struct Node {
        Point point;
        std::uint32_t number : 31;
        std::uint32_t by_x : 1;  ///< the point divides its range by x
    };
    struct Edge {
        Point a;
        Point b;
        FlatBox box;

        bool is_longer_than(const FlatBox& region) const noexcept {
            return box.height() > region.height() ||
                   std::int64_t{box.high.x} - box.low.x > std::int64_t{region.high.x} - region.low.x;
        }
        /// Whether all of `region`, with a unit around it, lies on one side.
        bool passes_by(const FlatBox& region) const noexcept;
    };
    static constexpr std::size_t leaf = 8;

    void divide(std::size_t begin, std::size_t end, StopPace& pace);

    /// `region` contains the points of [begin, end).
    template <class See>
    void find(std::size_t begin, std::size_t end, const FlatBox& region, const Edge& edge, See& see) const {
        if (end - begin <= leaf) {
            for (std::size_t i = begin; i < end; ++i) {
                const Point p = nodes_[i].point;
                if (edge.box.meets({p, p})) {
                    see(p, nodes_[i].number);
                }
            }
            return;
        }
        if (edge.is_longer_than(region) && edge.passes_by(region)) {
            return;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const Point p = nodes_[middle].point;
        const bool by_x = nodes_[middle].by_x != 0;
        FlatBox below = region;
        FlatBox above = region;
        (by_x ? below.high.x : below.high.y) = by_x ? p.x : p.y;
        (by_x ? above.low.x : above.low.y) = by_x ? p.x : p.y;
        if (edge.box.meets(below)) {
            find(begin, middle, below, edge, see);
        }
        if (edge.box.meets({p, p})) {
            see(p, nodes_[middle].number);
        }
        if (edge.box.meets(above)) {
            find(middle + 1, end, above, edge, see);
        }
    }

    /// Whether to go on.
    template <class See>
    bool find_in(std::size_t begin, std::size_t end, const FlatBox& box, See& see) const {
        if (end - begin <= leaf) {
            for (std::size_t i = begin; i < end; ++i) {
                if (!see_in(nodes_[i], box, see)) {
                    return false;
                }
            }
            return true;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const Node& node = nodes_[middle];
        const bool below = node.by_x != 0 ? box.low.x <= node.point.x : box.low.y <= node.point.y;
        const bool above = node.by_x != 0 ? node.point.x <= box.high.x : node.point.y <= box.high.y;
        return (!below || find_in(begin, middle, box, see)) && see_in(node, box, see) &&
               (!above || find_in(middle + 1, end, box, see));
    }

    template <class See>
    static bool see_in(const Node& node, const FlatBox& box, See& see) {
        return !box.meets({node.point, node.point}) || see(node.point, node.number);
    }

    Vector<Node> nodes_;
};

}  // namespace lamella
