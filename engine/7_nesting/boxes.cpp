#include "7_nesting/boxes.hpp"

#include <algorithm>
#include <cassert>

namespace lamella::nesting {

void BoxTree::reset(std::uint32_t count) {
    assert(count > 0);
    levels_.clear();
    std::uint32_t total = 0;
    for (std::uint32_t nodes = count; total == 0 || nodes > 1;) {
        nodes = (nodes - 1) / fan_out + 1;
        levels_.push_back({total, nodes});
        total += nodes;
    }
    nodes_.assign(total, Node{});
}

void BoxTree::add(std::uint32_t place, std::int32_t rank, Point box_min, Point box_max) noexcept {
    for (const Level& level : levels_) {
        Node& node = nodes_[level.first_node + place / fan_out];
        const std::uint32_t slot = place % fan_out;
        BoxQuad& quad = node.boxes[slot / 4];
        const std::uint32_t lane = slot % 4;
        if (quad.max_x[lane] == BoxQuad::nowhere) {
            quad.min_y[lane] = box_min.y;
            quad.max_y[lane] = box_max.y;
        }
        quad.max_x[lane] = std::max(quad.max_x[lane], box_max.x);
        quad.min_y[lane] = std::min(quad.min_y[lane], box_min.y);
        quad.max_y[lane] = std::max(quad.max_y[lane], box_max.y);
        node.last[slot] = rank;
        node.latest = slot;
        place /= fan_out;
    }
}

std::int32_t BoxTree::last_around(Point point) const noexcept {
    std::int32_t best = -1;
    search_last(levels_.size() - 1, 0, point, best);
    return best;
}

void BoxTree::all_around(Point point, std::size_t& patience, std::pmr::vector<std::int32_t>& found) const {
    search_all(levels_.size() - 1, 0, point, patience, found);
}

unsigned BoxTree::slots_around(const Node& node, Point point) noexcept {
    unsigned around = 0;
    for (std::uint32_t quad = 0; quad < quads; ++quad) {
        around |= node.boxes[quad].around(point) << (4 * quad);
    }
    return around;
}

std::uint32_t BoxTree::latest_slot(const Node& node, unsigned slots) noexcept {
    if ((slots >> node.latest & 1U) != 0) {
        return node.latest;
    }
    auto slot = static_cast<std::uint32_t>(std::countr_zero(slots));
    for (unsigned rest = slots & (slots - 1); rest != 0; rest &= rest - 1) {
        const auto other = static_cast<std::uint32_t>(std::countr_zero(rest));
        slot = node.last[other] > node.last[slot] ? other : slot;
    }
    return slot;
}

void BoxTree::search_last(std::size_t level, std::uint32_t node_index, Point point, std::int32_t& best) const noexcept {
    const Node& node = node_at(level, node_index);
    for (unsigned around = slots_around(node, point); around != 0;) {
        const std::uint32_t slot = latest_slot(node, around);
        if (node.last[slot] <= best) {
            return;
        }
        if (level == 0) {
            best = node.last[slot];
            return;
        }
        search_last(level - 1, node_index * fan_out + slot, point, best);
        around &= ~(1U << slot);
    }
}

void BoxTree::search_all(std::size_t level, std::uint32_t node_index, Point point, std::size_t& patience,
                         std::pmr::vector<std::int32_t>& found) const {
    const Node& node = node_at(level, node_index);
    for (unsigned around = slots_around(node, point); around != 0 && patience > 0; around &= around - 1) {
        const auto slot = static_cast<std::uint32_t>(std::countr_zero(around));
        --patience;
        if (level == 0) {
            found.push_back(node.last[slot]);
        } else {
            search_all(level - 1, node_index * fan_out + slot, point, patience, found);
        }
    }
}

}  // namespace lamella::nesting
