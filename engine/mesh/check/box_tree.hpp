// Boxes on the grid, found by where they lie: a tree without pointers over the boxes in Morton order, eight to a node.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
    /// O(n log n). Throws std::bad_alloc.
    BoxTree(std::span<const Box> boxes, const Parallel& parallel);

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

private:
    static constexpr std::size_t fan = 8;
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
