// Points of a plane in a tree, to find those in the bounding box of an edge that lie near the edge. The points are halved by
// x, the halves by y, and so on: the middle one of a range stands in its middle.
//
//         x         y       x              range [0, 7):  its middle, 3, divides by x
//     [ 5 | 2 | 6 | 0 | 3 | 1 | 4 ]        ranges [0, 3) and [4, 7): 1 and 5 divide by y
//           `-- y --'   ...
//
// O(n log n) to build, O(sqrt n) and what is found for a query along an edge; usually O(log n).
#pragma once

#include <cstdint>
#include <span>

#include "base/stop_pace.hpp"
#include "base/vector.hpp"
#include "lamella/grid.hpp"
#include "slicing/nesting/strips.hpp"

namespace lamella {

class PointTree {
public:
    explicit PointTree(const Memory* memory) : nodes_(memory) {}

    /// Numbers points[i] i. Throws std::bad_alloc.
    void build(std::span<const Point> points, StopPace& pace) {
        nodes_.clear();
        for (std::uint32_t i = 0; i < points.size(); ++i) {
            nodes_.push_back({points[i], i});
        }
        divide(0, nodes_.size(), true, pace);
    }

    /// Calls see(point, number) for each point in the bounding box of the edge from `a` to `b`, its sides included, but for
    /// some that lie two units and more off the edge.
    template <class See>
    void find_along(Point a, Point b, See see) const {
        const Edge edge{a, b, FlatBox::around(a, b)};
        constexpr Point least{-(grid_limit + 2), -(grid_limit + 2)};
        constexpr Point most{grid_limit + 2, grid_limit + 2};
        find(0, nodes_.size(), true, {least, most}, edge, see);
    }

private:
    struct Node {
        Point point;
        std::uint32_t number;
    };
    struct Edge {
        Point a;
        Point b;
        FlatBox box;

        /// Whether all of `region`, with a unit around it, lies on one side.
        bool passes_by(const FlatBox& region) const noexcept;
    };
    static constexpr std::size_t leaf = 8;

    void divide(std::size_t begin, std::size_t end, bool by_x, StopPace& pace);

    /// `region` contains the points of [begin, end).
    template <class See>
    void find(std::size_t begin, std::size_t end, bool by_x, const FlatBox& region, const Edge& edge, See& see) const {
        if (end - begin <= leaf) {
            for (std::size_t i = begin; i < end; ++i) {
                const Point p = nodes_[i].point;
                if (edge.box.meets({p, p})) {
                    see(p, nodes_[i].number);
                }
            }
            return;
        }
        if (edge.passes_by(region)) {
            return;
        }
        const std::size_t middle = begin + (end - begin) / 2;
        const Point p = nodes_[middle].point;
        FlatBox below = region;
        FlatBox above = region;
        (by_x ? below.high.x : below.high.y) = by_x ? p.x : p.y;
        (by_x ? above.low.x : above.low.y) = by_x ? p.x : p.y;
        if (edge.box.meets(below)) {
            find(begin, middle, !by_x, below, edge, see);
        }
        if (edge.box.meets({p, p})) {
            see(p, nodes_[middle].number);
        }
        if (edge.box.meets(above)) {
            find(middle + 1, end, !by_x, above, edge, see);
        }
    }

    Vector<Node> nodes_;
};

}  // namespace lamella
