// Boxes on the grid, found by where they lie: a tree without pointers, eight boxes to a node.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/eight.hpp"
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
};

/// Eight boxes side by side, so that all are compared at once.
class BoxBlock {
public:
    static constexpr std::size_t lanes = Eight::lanes;

    void set(std::size_t lane, const Box& box) noexcept {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low_[axis][lane] = box.low[axis];
            high_[axis][lane] = box.high[axis];
        }
    }
    Box operator[](std::size_t lane) const noexcept {
        return {{low_[0][lane], low_[1][lane], low_[2][lane]}, {high_[0][lane], high_[1][lane], high_[2][lane]}};
    }

    /// Which meet the other.
    LaneBits meets(const Box& other) const noexcept {
        Eight apart(0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            apart = apart | (Eight(low_[axis]) > Eight(other.high[axis])) | (Eight(other.low[axis]) > Eight(high_[axis]));
        }
        return ~apart.bits() & all_eight;
    }

private:
    std::array<Eight::Stored, 3> low_;
    std::array<Eight::Stored, 3> high_;
};

/// Items come in an order in which neighbours lie close, as the vertices of a GridMesh do: eight that follow one another are
/// a group.
class BoxTree {
public:
    /// The box of an item; called once for each.
    using BoxOf = FunctionRef<Box(std::size_t item)>;
    static constexpr std::size_t fan = BoxBlock::lanes;  ///< boxes of a node

    /// O(n), in at most 11 calls of run(). Throws std::bad_alloc.
    BoxTree(std::size_t count, BoxOf box_of, const Parallel& parallel, const Memory* memory = nullptr);

    std::size_t size() const noexcept { return size_; }

    /// What visit() costs in comparisons of boxes: an exact test of two triangles takes as long.
    static constexpr std::size_t visit_cost = 64;

    /// Calls visit(item) for each box that meets the query, until that has cost `limit`; returns what it cost.
    template <class Visit>
    std::size_t search(const Box& query, std::size_t limit, Visit visit) const {
        return descend(query, 0, limit, [&](std::size_t leaf, LaneBits met) {
            each_lane(met, [&](std::size_t lane) { visit(leaf * fan + lane); });
            return visit_cost * static_cast<std::size_t>(std::popcount(met));
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
        const BoxBlock& own = levels_[0][group];
        return descend(all_of(own), group, limit, [&](std::size_t leaf, LaneBits met) {
            std::size_t pairs = 0;
            each_lane(met, [&](std::size_t lane) {
                const LaneBits before = leaf == group ? (LaneBits{1} << lane) - 1 : all_eight;
                if (const LaneBits bits = own.meets(levels_[0][leaf][lane]) & before; bits != 0) {
                    visit(leaf * fan + lane, bits);
                    pairs += static_cast<std::size_t>(std::popcount(bits));
                }
            });
            return fan * fan + visit_cost * pairs;
        });
    }

private:
    static constexpr std::size_t deepest = 11;  ///< 8^11 exceeds 2^32

    /// Where it has fewer than eight, the others meet nothing.
    static Box all_of(const BoxBlock& block) noexcept;

    /// Calls visit(leaf, bits) for each leaf from `first` on of which boxes meet the query, a bit for each; visit() returns
    /// what it cost. Ends when all has cost `limit`; returns that cost.
    template <class Visit>
    std::size_t descend(const Box& query, std::size_t first, std::size_t limit, Visit visit) const {
        struct Node {
            std::size_t level;
            std::size_t block;
        };
        std::array<Node, deepest * fan> stack;
        std::size_t depth = 0;
        std::size_t cost = 0;
        stack[depth++] = {levels_.size() - 1, 0};
        while (depth > 0 && cost < limit) {
            const auto [level, block] = stack[--depth];
            cost += fan;
            const LaneBits met = levels_[level][block].meets(query);
            if (level == 0) {
                cost += visit(block, met);
                continue;
            }
            each_lane(met, [&, level = level, block = block](std::size_t lane) {
                const std::size_t child = block * fan + lane;
                if (child >= first >> (3 * (level - 1))) {
                    stack[depth++] = {level - 1, child};
                }
            });
        }
        return cost;
    }

    std::size_t size_;
    std::vector<Array<BoxBlock>> levels_;  ///< [0]: the boxes; a box of a level holds a block of that below
};

}  // namespace lamella
