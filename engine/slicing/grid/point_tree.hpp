// Points of a plane in a tree: those in a box, those near an edge, the nearest one. O(n log n) to build. O(sqrt n) and what
// is found for a query along an edge; usually O(log n).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/box.hpp"
#include "slicing/grid/box_tree.hpp"

namespace lamella {

inline double squared_distance(Point a, Point b) noexcept {
    const double dx = static_cast<double>(a.x) - b.x;
    const double dy = static_cast<double>(a.y) - b.y;
    return dx * dx + dy * dy;
}

class PointTree {
public:
    static constexpr std::uint32_t none = ~0U;

    explicit PointTree(Worker& worker) noexcept : worker_(worker) {}

    /// Points at(0) to at(count - 1), fewer than 2^32 - 1. `aspect`: the mean width of the boxes that will be searched over
    /// their mean height. Throws std::bad_alloc.
    template <class At>
    void assign(std::size_t count, const At& at, double aspect = 1) {
        points_.clear();
        points_.reserve(count);
        worker_.in_stretches(0, count, 4, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                points_.push_back({at(i), static_cast<std::uint32_t>(i)});
            }
        });
        order_by_place(
            std::span(points_), [](const Numbered& numbered) { return numbered.point; }, worker_, aspect);
        place_of_.resize(count);
        worker_.in_stretches(0, count, 2, [&](std::size_t first, std::size_t last) {
            for (std::size_t place = first; place < last; ++place) {
                place_of_[points_[place].number] = static_cast<std::uint32_t>(place);
            }
        });
        const auto box_at = [this](std::size_t i) { return FlatBox{points_[i].point, points_[i].point}; };
        boxes_.assign(count, box_at, worker_);
    }

    /// The point is not found again. O(log n).
    void take_off(std::uint32_t number) noexcept { boxes_.take_off(place_of_[number]); }

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

    /// Calls see(point, number) for each point in `box`, its sides included, until it returns false. In no order, but the
    /// same every time.
    template <class See>
    void find_in(const FlatBox& box, See see) const {
        boxes_.search_if([&](const BoxBlock<Point>& block) { return block.meets(box); },
                         [&](std::size_t i) { return see(points_[i].point, points_[i].number); });
    }

    /// The nearest point, at most the square root of `most_squared` away, or none. At equal distances the smallest number.
    /// The point `but` is passed over.
    std::uint32_t nearest(Point to, double most_squared, std::uint32_t but) const {
        Nearest best{most_squared, none, but};
        search(boxes_.levels() - 1, 0, to, best);
        return best.number;
    }

private:
    struct Numbered {
        Point point;
        std::uint32_t number;
    };
    struct Nearest {
        double squared;
        std::uint32_t number;
        std::uint32_t but;
    };

    /// A lower bound for squared_distance() to any point in the box: it rounds in the same way.
    static double squared_distance_to(const FlatBox& box, Point point) noexcept {
        if (exceeds(box.low, box.high)) {
            return std::numeric_limits<double>::infinity();
        }
        return squared_distance(point, high_corner(box.low, low_corner(box.high, point)));
    }

    /// The boxes of a block, the nearest first.
    void search(std::size_t level, std::size_t block, Point to, Nearest& best) const {
        constexpr std::size_t fan = BoxTree<Point>::fan;
        worker_.spend(fan);
        std::array<std::pair<double, std::size_t>, fan> near;
        std::size_t count = 0;
        for (std::size_t lane = 0; lane < fan; ++lane) {
            const double squared = squared_distance_to(boxes_.block(level, block)[lane], to);
            if (squared <= best.squared) {
                std::size_t at = count++;
                for (; at > 0 && squared < near[at - 1].first; --at) {
                    near[at] = near[at - 1];
                }
                near[at] = {squared, block * fan + lane};
            }
        }
        for (std::size_t i = 0; i < count && near[i].first <= best.squared; ++i) {
            const auto [squared, child] = near[i];
            if (level > 0) {
                search(level - 1, child, to, best);
                continue;
            }
            const std::uint32_t number = points_[child].number;
            if (number != best.but && (squared < best.squared || number < best.number)) {
                best = {squared, number, best.but};
            }
        }
    }

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

    Worker& worker_;
    Vector<Numbered> points_{worker_.memory()};         // by place
    Vector<std::uint32_t> place_of_{worker_.memory()};  // of each number
    BoxTree<Point> boxes_{worker_.memory()};            // of points_, but for those taken off
};

}  // namespace lamella
