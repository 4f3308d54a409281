#include "mesh/check/box_tree.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace lamella {

namespace {

constexpr std::size_t box_grain = 8192;

constexpr Box nothing() {
    constexpr std::int32_t least = std::numeric_limits<std::int32_t>::min();
    constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
    return {{most, most, most}, {least, least, least}};
}

}  // namespace

Box Box::around(std::span<const GridVertex> points) noexcept {
    Box box = nothing();
    for (const GridVertex& p : points) {
        box.include({{p.x, p.y, p.z}, {p.x, p.y, p.z}});
    }
    return box;
}

void Box::include(const Box& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], other.low[axis]);
        high[axis] = std::max(high[axis], other.high[axis]);
    }
}

BoxTree::BoxTree(std::size_t count, BoxOf box_of, const Parallel& parallel, const Memory* memory) : size_(count) {
    assert(count < std::numeric_limits<std::uint32_t>::max());
    const auto add_level = [&](std::size_t boxes_in_it, auto box_at) {
        Array<BoxBlock>& level = levels_.emplace_back(memory);
        level.resize_discarding(std::max<std::size_t>((boxes_in_it + fan - 1) / fan, 1));
        parallel.run_ranges(level.size(), box_grain / fan, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t block = begin; block != end; ++block) {
                for (std::size_t lane = 0; lane < fan; ++lane) {
                    const std::size_t box = block * fan + lane;
                    level[block].set(lane, box < boxes_in_it ? box_at(box) : nothing());
                }
            }
        });
    };
    add_level(count, box_of);
    while (levels_.back().size() > 1) {
        const BoxBlock* const below = levels_.back().data();
        add_level(levels_.back().size(), [&](std::size_t block) { return all_of(below[block]); });
    }
    assert(levels_.size() <= deepest);
}

Box BoxTree::all_of(const BoxBlock& block) noexcept {
    Box all = block[0];
    for (std::size_t lane = 1; lane < fan; ++lane) {
        all.include(block[lane]);
    }
    return all;
}

}  // namespace lamella
