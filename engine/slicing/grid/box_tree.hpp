// Boxes on the grid, found by where they lie: a tree without pointers, eight boxes to a node. Points are boxes too.
//
//     level 1   [      0      |      1    ]
//     level 0   [ 0 1 2 3 ... | 8 9 ...   ]      a box of a level holds a block of eight of the level below
//
// Items come in an order in which neighbours lie close: that of the vertices of a GridMesh, that along a chain of edges, or
// that of order_by_place(). Whoever searches goes down from the root and leaves out what it need not see.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "base/eight.hpp"
#include "base/numbers.hpp"
#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "lamella/array.hpp"
#include "lamella/grid.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

/// Int32x8 boxes side by side, so that all are compared at once.
template <class Corner>
class BoxBlock {
public:
    static constexpr std::size_t lanes = Int32x8::lanes;
    static constexpr std::size_t axes = GridBox<Corner>::axes;

    void set(std::size_t lane, const GridBox<Corner>& box) noexcept {
        const auto [low, high] = box.numbers();
        for (std::size_t axis = 0; axis < axes; ++axis) {
            low_[axis][lane] = low[axis];
            high_[axis][lane] = high[axis];
        }
    }
    /// Those of edges from a point to the next; there are nine.
    void set_edges(const Corner* points) noexcept requires(axes == 2) {
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            low_[0][lane] = std::min(points[lane].x, points[lane + 1].x);
            low_[1][lane] = std::min(points[lane].y, points[lane + 1].y);
            high_[0][lane] = std::max(points[lane].x, points[lane + 1].x);
            high_[1][lane] = std::max(points[lane].y, points[lane + 1].y);
        }
    }
    GridBox<Corner> operator[](std::size_t lane) const noexcept {
        typename GridBox<Corner>::Numbers numbers;
        for (std::size_t axis = 0; axis < axes; ++axis) {
            numbers.low[axis] = low_[axis][lane];
            numbers.high[axis] = high_[axis][lane];
        }
        return bits_as<GridBox<Corner>>(numbers);
    }

    /// Which meet the other.
    LaneBits meets(const GridBox<Corner>& other) const noexcept {
        const auto [low, high] = other.numbers();
        Int32x8 apart(0);
        for (std::size_t axis = 0; axis < axes; ++axis) {
            apart = apart | (Int32x8(low_[axis]) > Int32x8(high[axis])) | (Int32x8(low[axis]) > Int32x8(high_[axis]));
        }
        return ~apart.bits() & all_eight;
    }

    /// Where it has fewer than eight, the others meet nothing.
    GridBox<Corner> all() const noexcept {
        typename GridBox<Corner>::Numbers numbers;
        for (std::size_t axis = 0; axis < axes; ++axis) {
            numbers.low[axis] = *std::min_element(low_[axis].begin(), low_[axis].end());
            numbers.high[axis] = *std::max_element(high_[axis].begin(), high_[axis].end());
        }
        return bits_as<GridBox<Corner>>(numbers);
    }

private:
    std::array<Int32x8::Stored, axes> low_;
    std::array<Int32x8::Stored, axes> high_;
};

/// Its memory is kept from use to use.
template <class Corner>
class BoxTree {
public:
    using Block = BoxBlock<Corner>;
    static constexpr std::size_t fan = Block::lanes;  ///< boxes of a node

    explicit BoxTree(const Memory* memory = nullptr) noexcept : blocks_(memory) {}

    /// Items [0, count), of which box_at(item) is called once for each. O(n). Throws std::bad_alloc.
    template <class BoxAt>
    void assign(std::size_t count, const BoxAt& box_at, StopPace& pace) {
        constexpr std::size_t block_work = 4 * fan;
        build(count, box_at, [&](std::size_t blocks, const auto& fill) { pace.in_stretches(0, blocks, block_work, fill); });
    }
    /// The same in at most 11 calls of run().
    template <class BoxAt>
    void assign(std::size_t count, const BoxAt& box_at, const Parallel& parallel) {
        constexpr std::size_t grain = 1024;
        build(count, box_at, [&](std::size_t blocks, const auto& fill) {
            parallel.run_ranges(blocks, grain, [&](std::size_t begin, std::size_t end, int) { fill(begin, end); });
        });
    }

    std::size_t size() const noexcept { return size_; }
    std::size_t levels() const noexcept { return levels_; }
    /// On level 0: the boxes of eight items.
    const Block& block(std::size_t level, std::size_t number) const noexcept { return blocks_[firsts_[level] + number]; }

    /// From here on the item meets nothing; the boxes around it shrink. O(log n).
    void take_off(std::size_t item) noexcept {
        GridBox<Corner> left = GridBox<Corner>::nothing();
        for (std::size_t level = 0; level < levels_; ++level, item /= fan) {
            Block& block = blocks_[firsts_[level] + item / fan];
            if (block[item % fan] == left) {
                return;
            }
            block.set(item % fan, left);
            left = block.all();
        }
    }

    /// The cost of visit() in comparisons of boxes: an exact test of two triangles takes as long.
    static constexpr std::size_t visit_cost = 64;

    /// Calls visit(item) for each box that meets the query, until that has cost `limit`; returns what it cost.
    template <class Visit>
    std::size_t search(const GridBox<Corner>& query, std::size_t limit, Visit visit) const {
        const auto enter = [&](const Block& block) { return block.meets(query); };
        return descend(enter, 0, limit, [&](std::size_t leaf, LaneBits met) {
            each_lane(met, [&](std::size_t lane) { visit(leaf * fan + lane); });
            return visit_cost * static_cast<std::size_t>(std::popcount(met));
        });
    }

    /// Calls visit(item) for each item that enter() lets pass with all that lies around it, until visit() returns false.
    /// enter(block) gives a bit for each box of the block to go on in.
    template <class Enter, class Visit>
    void search_if(const Enter& enter, Visit visit) const {
        constexpr std::size_t endless = std::numeric_limits<std::size_t>::max() / 2;
        descend(enter, 0, endless, [&](std::size_t leaf, LaneBits met) {
            bool goes_on = true;
            each_lane(met, [&](std::size_t lane) { goes_on = goes_on && visit(leaf * fan + lane); });
            return goes_on ? 0 : endless;
        });
    }

    /// Neighbouring positions, of which a group holds eight, the last one what is left.
    std::size_t groups() const noexcept { return (size() + fan - 1) / fan; }
    std::size_t group_begin(std::size_t group) const noexcept { return group * fan; }
    std::size_t group_end(std::size_t group) const noexcept { return std::min(size(), (group + 1) * fan); }

    /// Calls visit(other, bits) for boxes that meet boxes of the group at positions before them: a bit for each of these.
    /// Ends when that has cost `limit`; returns what it cost.
    template <class Visit>
    std::size_t search_pairs(std::size_t group, std::size_t limit, Visit visit) const {
        const GridBox<Corner> query = block(0, group).all();
        const auto enter = [&](const Block& block) { return block.meets(query); };
        std::array<std::size_t, others_at_once + fan> others;  // boxes of leaves that meet the query
        std::size_t count = 0;
        const std::size_t cost = descend(enter, group, limit, [&](std::size_t leaf, LaneBits met) {
            count = append_lanes(met, leaf * fan, others.data(), count);
            const std::size_t visits =
                count >= others_at_once ? visit_pairs(group, others, std::exchange(count, 0), visit) : 0;
            return fan * fan + visits;
        });
        return cost + visit_pairs(group, others, count, visit);
    }

private:
    static constexpr std::size_t deepest = 11;         ///< 8^11 exceeds 2^32
    static constexpr std::size_t others_at_once = 56;  ///< of one search

    /// Appends first + lane for each bit that is set. Has room for all eight; a branch on each bit would be mispredicted.
    static std::size_t append_lanes(LaneBits bits, std::size_t first, std::size_t* to, std::size_t count) noexcept {
        for (std::size_t lane = 0; lane < fan; ++lane) {
            to[count] = first + lane;
            count += bits >> lane & 1U;
        }
        return count;
    }

    /// Returns what it cost.
    template <class Others, class Visit>
    std::size_t visit_pairs(std::size_t group, const Others& others, std::size_t count, const Visit& visit) const {
        const Block& own = block(0, group);
        std::array<std::pair<std::size_t, LaneBits>, std::tuple_size_v<Others>> met;
        std::size_t met_count = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t lane = others[i] % fan;
            const LaneBits before = others[i] / fan == group ? (LaneBits{1} << lane) - 1 : all_eight;
            met[met_count] = {others[i], own.meets(block(0, others[i] / fan)[lane]) & before};
            met_count += met[met_count].second != 0 ? 1U : 0U;
        }
        std::size_t pairs = 0;
        for (std::size_t i = 0; i < met_count; ++i) {
            visit(met[i].first, met[i].second);
            pairs += static_cast<std::size_t>(std::popcount(met[i].second));
        }
        return visit_cost * pairs;
    }

    /// run(blocks, fill) calls fill(begin, end) for ranges of all blocks of a level.
    template <class BoxAt, class Run>
    void build(std::size_t count, const BoxAt& box_at, const Run& run) {
        assert(count < std::numeric_limits<std::uint32_t>::max());
        size_ = count;
        levels_ = 0;
        firsts_[0] = 0;
        std::size_t blocks = count;
        do {
            blocks = std::max<std::size_t>((blocks + fan - 1) / fan, 1);
            firsts_[levels_ + 1] = firsts_[levels_] + blocks;
            ++levels_;
        } while (blocks > 1);
        const std::size_t all = firsts_[levels_];
        if (all > blocks_.capacity()) {  // the first layer says little about the next ones
            blocks_.resize_discarding(blocks_.capacity() == 0 ? all : all + all / 2);
        }
        blocks_.set_size(all);
        const auto fill_level = [&](std::size_t level, std::size_t boxes, const auto& box_of) {
            Block* const to = blocks_.data() + firsts_[level];
            run(firsts_[level + 1] - firsts_[level], [=, &box_of](std::size_t begin, std::size_t end) {
                for (std::size_t box = begin * fan; box < end * fan; ++box) {
                    to[box / fan].set(box % fan, box < boxes ? box_of(box) : GridBox<Corner>::nothing());
                }
            });
        };
        fill_level(0, count, box_at);
        for (std::size_t level = 1; level < levels_; ++level) {
            const Block* const below = blocks_.data() + firsts_[level - 1];
            fill_level(level, firsts_[level] - firsts_[level - 1], [below](std::size_t box) { return below[box].all(); });
        }
    }

    /// Calls visit(leaf, bits) for each leaf from `first` on of which enter() lets boxes pass, a bit for each; visit()
    /// returns what it cost. Ends when all has cost `limit`; returns that cost.
    template <class Enter, class Visit>
    std::size_t descend(const Enter& enter, std::size_t first, std::size_t limit, Visit visit) const {
        struct Node {
            std::size_t level;
            std::size_t block;
        };
        std::array<Node, deepest * fan + 1> stack;
        std::size_t depth = 0;
        std::size_t cost = 0;
        stack[depth++] = {levels_ - 1, 0};
        while (depth > 0 && cost < limit) {
            const auto [level, number] = stack[--depth];
            cost += fan;
            const LaneBits met = enter(block(level, number));
            if (level == 0) {
                cost += visit(number, met);
                continue;
            }
            const std::size_t least = first >> (3 * (level - 1));
            for (std::size_t lane = 0; lane < fan; ++lane) {  // without a branch, as in append_lanes()
                const std::size_t child = number * fan + lane;
                stack[depth] = {level - 1, child};
                depth += child >= least ? met >> lane & 1U : 0U;
            }
        }
        return cost;
    }

    std::size_t size_ = 0;
    std::size_t levels_ = 0;
    std::array<std::size_t, deepest + 1> firsts_{};  ///< of each level, and the end of the last
    Array<Block> blocks_;                            ///< level by level
};

/// Halves items with places at(item) across the longer side of their box, until eight are left. The first half fills whole
/// nodes.
template <class Item, class At>
void halve_by_place(std::span<Item> items, const At& at, StopPace& pace) {
    constexpr std::size_t fan = BoxTree<Point>::fan;
    if (items.size() <= fan) {
        return;
    }
    FlatBox box = FlatBox::nothing();
    for (const Item& item : items) {
        box.include({at(item), at(item)});
    }
    std::size_t node = fan;
    while (node * fan < items.size()) {
        node *= fan;
    }
    const std::size_t half = (items.size() + node - 1) / node / 2 * node;
    pace.spend(4 * items.size());
    const auto middle = items.begin() + static_cast<std::ptrdiff_t>(half);
    if (width_of(box) > height_of(box)) {
        std::nth_element(items.begin(), middle, items.end(),
                         [&](const Item& a, const Item& b) { return at(a).x < at(b).x; });
    } else {
        std::nth_element(items.begin(), middle, items.end(),
                         [&](const Item& a, const Item& b) { return at(a).y < at(b).y; });
    }
    halve_by_place(items.first(half), at, pace);
    halve_by_place(items.subspan(half), at, pace);
}

/// Orders items with places at(item) for a tree: halves them. Those that come in the order of x are cut before, into as many
/// strips as each has blocks of eight. O(n log n).
template <class Item, class At>
void order_by_place(std::span<Item> items, const At& at, StopPace& pace) {
    constexpr std::size_t fan = BoxTree<Point>::fan;
    std::size_t strip = items.size();
    pace.spend(items.size());
    if (std::is_sorted(items.begin(), items.end(), [&](const Item& a, const Item& b) { return at(a).x < at(b).x; })) {
        const auto strips = static_cast<std::size_t>(std::sqrt(static_cast<double>(items.size()) / fan)) + 1;
        strip = (items.size() / strips / fan + 1) * fan;
    }
    for (std::size_t first = 0; first < items.size(); first += strip) {
        halve_by_place(items.subspan(first, std::min(strip, items.size() - first)), at, pace);
    }
}

// Boxes along an edge.

/// On which side of the line through `a` in the direction (dx, dy) all of `box` lies, with a unit around it: 1 left, -1
/// right; 0 on both, or so near that double precision cannot tell: products of 33 bits and 31 have an error of less than
/// 2^13.
inline int side_of_box(Point a, double dx, double dy, const FlatBox& box) noexcept {
    const double middle_x = (static_cast<double>(box.low.x) + box.high.x) / 2 - a.x;
    const double middle_y = (static_cast<double>(box.low.y) + box.high.y) / 2 - a.y;
    const double half_x = static_cast<double>(width_of(box)) / 2 + 2;
    const double half_y = static_cast<double>(height_of(box)) / 2 + 2;
    const double distance = dx * middle_y - dy * middle_x;
    constexpr double room = 1 << 14;
    return std::abs(distance) > std::abs(dx) * half_y + std::abs(dy) * half_x + room ? sign_of(distance) : 0;
}

/// Those that meet the box of the edge from `a` to `b`, but for some that lie two units and more off the edge.
inline LaneBits lanes_along(const BoxBlock<Point>& block, Point a, Point b) noexcept {
    const double dx = static_cast<double>(b.x) - a.x;
    const double dy = static_cast<double>(b.y) - a.y;
    LaneBits met = block.meets(FlatBox::around(a, b));
    each_lane(met, [&](std::size_t lane) { met &= ~(LaneBits{side_of_box(a, dx, dy, block[lane]) != 0} << lane); });
    return met;
}

// Points of a plane in a tree: those in a box, those near an edge, the nearest one. O(n log n) to build. O(sqrt n) and what
// is found for a query along an edge; usually O(log n).

inline double squared_distance(Point a, Point b) noexcept {
    const double dx = static_cast<double>(a.x) - b.x;
    const double dy = static_cast<double>(a.y) - b.y;
    return dx * dx + dy * dy;
}

class PointTree {
public:
    static constexpr std::uint32_t none = ~0U;

    explicit PointTree(Worker& worker) noexcept : worker_(worker) {}

    /// Points at(0) to at(count - 1), fewer than 2^32 - 1. Throws std::bad_alloc.
    template <class At>
    void assign(std::size_t count, const At& at) {
        points_.clear();
        points_.reserve(count);
        worker_.in_stretches(0, count, 4, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                points_.push_back({at(i), static_cast<std::uint32_t>(i)});
            }
        });
        order_by_place(
            std::span(points_), [](const Numbered& numbered) { return numbered.point; }, worker_);
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
        const auto enter = [&](const BoxBlock<Point>& block) {
            worker_.spend(BoxTree<Point>::fan);
            return lanes_along(block, a, b);
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

    Worker& worker_;
    Vector<Numbered> points_{worker_.memory()};         // by place
    Vector<std::uint32_t> place_of_{worker_.memory()};  // of each number
    BoxTree<Point> boxes_{worker_.memory()};            // of points_, but for those taken off
};

}  // namespace lamella
