// Boxes on the grid, found by where they lie: a tree without pointers over the boxes in Morton order, eight to a node.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/grid.hpp"

namespace lamella {

/// Closed.
struct Box {
    std::array<std::int32_t, 3> low;
    std::array<std::int32_t, 3> high;

    static Box around(std::span<const GridVertex> points) noexcept;
    void include(const Box& other) noexcept;

    bool meets(const Box& other) const noexcept {
        int met = 1;  // without branches: which of the six comparisons fails cannot be predicted
        for (std::size_t axis = 0; axis < 3; ++axis) {
            met &= static_cast<int>(low[axis] <= other.high[axis]);
            met &= static_cast<int>(other.low[axis] <= high[axis]);
        }
        return met != 0;
    }
};

/// Items are numbered as the boxes were given; positions count them in Morton order.
class BoxTree {
public:
    /// The box of an item; called once for each.
    using BoxOf = FunctionRef<Box(std::size_t item)>;
    static constexpr std::size_t fan = 8;  ///< boxes of a node

    /// O(n log n), in at most 15 calls of run(). Throws std::bad_alloc.
    BoxTree(std::size_t count, BoxOf box_of, const Parallel& parallel);

    std::size_t size() const noexcept { return items_.size(); }
    std::uint32_t item_at(std::size_t position) const noexcept { return items_[position]; }
    const Box& box_at(std::size_t position) const noexcept { return levels_[0][position]; }

    /// What visit() costs in comparisons of boxes: an exact test of two triangles takes as long.
    static constexpr std::size_t visit_cost = 64;

    /// Calls visit(item) for each box at position `from` or later that meets the query, until that has cost `limit`;
    /// returns what it cost.
    template <class Visit>
    std::size_t search(const Box& query, std::size_t from, std::size_t limit, Visit visit) const {
        std::array<Node, deepest * fan> stack;
        std::size_t depth = 0;
        std::size_t cost = 0;
        stack[depth++] = {levels_.size() - 1, 0};
        while (depth > 0 && cost < limit) {
            const auto [level, group] = stack[--depth];
            const Array<Box>& boxes = levels_[level];
            const std::size_t end = std::min(boxes.size(), (group + 1) * fan);
            cost += end - group * fan;
            for (std::size_t i = group * fan; i != end; ++i) {
                if (!query.meets(boxes[i]) || last_position(level, i) < from) {
                    continue;
                }
                if (level == 0) {
                    visit(items_[i]);
                    cost += visit_cost;
                } else {
                    stack[depth++] = {level - 1, i};
                }
            }
        }
        return cost;
    }

    /// Neighbouring positions, of which a group holds eight, the last one what is left.
    std::size_t groups() const noexcept { return (size() + fan - 1) / fan; }
    std::size_t group_begin(std::size_t group) const noexcept { return group * fan; }
    std::size_t group_end(std::size_t group) const noexcept { return std::min(size(), (group + 1) * fan); }

    /// Calls visit(position, other) for each pair of boxes that meet, the first in the group and the other one after it,
    /// until that has cost `limit`; returns what it cost.
    template <class Visit>
    std::size_t search_pairs(std::size_t group, std::size_t limit, Visit visit) const {
        const Group own = group_of(group);
        std::array<Node, deepest * fan> stack;
        std::size_t depth = 0;
        std::size_t cost = 0;
        stack[depth++] = {levels_.size() - 1, 0};
        while (depth > 0 && cost < limit) {
            const auto [level, node] = stack[--depth];
            if (level == 0) {
                cost += fan * fan + visit_cost * search_groups(own, node, visit);
                continue;
            }
            const Array<Box>& nodes = levels_[level];
            const std::size_t end = std::min(nodes.size(), (node + 1) * fan);
            cost += end - node * fan;
            for (std::size_t i = node * fan; i != end; ++i) {
                if (own.all.meets(nodes[i]) && last_position(level, i) >= own.first) {
                    stack[depth++] = {level - 1, i};
                }
            }
        }
        return cost;
    }

private:
    /// The boxes of a group side by side, so that all are compared at once. Where it has fewer the first one stands again,
    /// at positions beyond the last.
    struct Group {
        std::size_t first;
        Box all;
        std::array<std::array<std::int32_t, fan>, 3> low;
        std::array<std::array<std::int32_t, fan>, 3> high;

        std::array<std::int32_t, fan> meets(const Box& other) const noexcept {
            std::array<std::int32_t, fan> met;
            met.fill(-1);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (std::size_t i = 0; i < fan; ++i) {
                    met[i] &= low[axis][i] <= other.high[axis] ? -1 : 0;
                    met[i] &= other.low[axis] <= high[axis][i] ? -1 : 0;
                }
            }
            return met;
        }
    };

    Group group_of(std::size_t group) const noexcept {
        Group sides{};
        sides.first = group_begin(group);
        sides.all = levels_[0][sides.first];
        for (std::size_t i = 0; i < fan; ++i) {
            const std::size_t at = sides.first + i < group_end(group) ? sides.first + i : sides.first;
            sides.all.include(levels_[0][at]);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                sides.low[axis][i] = levels_[0][at].low[axis];
                sides.high[axis][i] = levels_[0][at].high[axis];
            }
        }
        return sides;
    }

    /// visit() for the pairs of two groups; returns their number.
    template <class Visit>
    std::size_t search_groups(const Group& group, std::size_t other, Visit& visit) const {
        const Array<Box>& boxes = levels_[0];
        std::size_t pairs = 0;
        for (std::size_t j = group_begin(other); j != group_end(other); ++j) {
            if (!group.all.meets(boxes[j])) {
                continue;
            }
            const std::array<std::int32_t, fan> met = group.meets(boxes[j]);
            for (std::size_t i = 0; i != fan && group.first + i < j; ++i) {
                if (met[i] != 0) {
                    visit(group.first + i, j);
                    ++pairs;
                }
            }
        }
        return pairs;
    }

    void sort_items(const Array<Box>& boxes, const Parallel& parallel);

    static constexpr std::size_t deepest = 11;  ///< 8^11 exceeds 2^32

    /// Boxes [group * fan, (group + 1) * fan) of a level, which are what box `group` of the level above holds.
    struct Node {
        std::size_t level;
        std::size_t group;
    };

    static std::size_t last_position(std::size_t level, std::size_t box) noexcept { return ((box + 1) << (3 * level)) - 1; }

    Array<std::uint32_t> items_;      ///< by position
    std::vector<Array<Box>> levels_;  ///< [0]: the boxes by position; the last has at most eight
};

}  // namespace lamella
