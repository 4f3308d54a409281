#include "slicing/nesting/start_tree.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace lamella::nesting {

/// A box meets about (1 + s · height) · (1 + n / s · width) of n leaves in s strips, its sides as shares of the layer's:
/// fewest where s² is n · width / height.
void StartTree::assign(std::span<const SortKey> by_start, double slimness) {
    assert(!by_start.empty() && slimness >= 0);
    const double leaves = std::ceil(static_cast<double>(by_start.size()) / lanes);
    order_places(by_start, static_cast<std::uint32_t>(std::clamp(std::sqrt(leaves * slimness), 1.0, leaves)));
    levels_.clear();
    std::uint32_t total = 0;
    for (auto nodes = static_cast<std::uint32_t>(by_start.size()); total == 0 || nodes > 1;) {
        nodes = (nodes - 1) / lanes + 1;
        levels_.push_back(total);
        total += nodes;
    }
    nodes_.resize(total);
    for (Node& node : nodes_) {
        node.left = 0;
    }
    for (std::uint32_t place = 0; place < by_start.size(); ++place) {
        constexpr std::size_t start_work = 8;  // as StopPace counts it
        pace_.spend(start_work);
        const std::uint64_t key = by_start[start_at_[place]].key;
        add(place, {x_of(key), y_of(key)});
    }
}

/// Equal strips by y, each in the order of x.
void StartTree::order_places(std::span<const SortKey> by_start, std::uint32_t strips) {
    const auto count = static_cast<std::uint32_t>(by_start.size());
    const std::uint32_t strip = ((count - 1) / (strips * lanes) + 1) * lanes;  // starts
    by_y_.clear();
    for (std::uint32_t start = 0; start < count; ++start) {
        by_y_.push_back({static_cast<std::uint32_t>(by_start[start].key), start});
    }
    sort_keys(by_y_, spare_, pace_);
    start_at_.resize(count);
    strip_of_.resize(count);
    for (std::uint32_t rank = 0; rank < count; ++rank) {
        pace_.spend(2);
        strip_of_[by_y_[rank].index] = rank / strip;
    }
    next_place_.clear();
    for (std::uint32_t first = 0; first < count; first += strip) {
        next_place_.push_back(first);
    }
    place_of_.resize(count);
    for (std::uint32_t start = 0; start < count; ++start) {
        pace_.spend(2);
        place_of_[start] = next_place_[strip_of_[start]]++;
        start_at_[place_of_[start]] = start;
    }
}

void StartTree::add(std::uint32_t place, Point start) noexcept {
    for (const std::uint32_t first_node : levels_) {
        Node& node = nodes_[first_node + place / lanes];
        const std::uint32_t child = place % lanes;
        const bool first = (node.left >> child & 1U) == 0;
        node.min_x[child] = first ? start.x : std::min(node.min_x[child], start.x);
        node.max_x[child] = first ? start.x : std::max(node.max_x[child], start.x);
        node.min_y[child] = first ? start.y : std::min(node.min_y[child], start.y);
        node.max_y[child] = first ? start.y : std::max(node.max_y[child], start.y);
        node.left |= 1U << child;
        place /= lanes;
    }
}

void StartTree::find(Point box_min, Point box_max, Vector<std::uint32_t>& found) const {
    search(levels_.size() - 1, 0, box_min, box_max, found);
}

void StartTree::search(std::size_t level, std::uint32_t node_index, Point box_min, Point box_max,
                       Vector<std::uint32_t>& found) const {
    constexpr std::int32_t lowest = std::numeric_limits<std::int32_t>::min();
    constexpr std::int32_t highest = std::numeric_limits<std::int32_t>::max();
    const Node& node = nodes_[levels_[level] + node_index];
    unsigned met = node.left & between(node.max_x, box_min.x, highest) & between(node.min_x, lowest, box_max.x) &
                   between(node.max_y, box_min.y, highest) & between(node.min_y, lowest, box_max.y);
    for (; met != 0; met &= met - 1) {
        const std::uint32_t child = node_index * lanes + static_cast<std::uint32_t>(std::countr_zero(met));
        if (level == 0) {
            found.push_back(start_at_[child]);
        } else {
            search(level - 1, child, box_min, box_max, found);
        }
    }
}

void StartTree::take_off(std::uint32_t start) noexcept {
    std::uint32_t place = place_of_[start];
    for (const std::uint32_t first_node : levels_) {
        Node& node = nodes_[first_node + place / lanes];
        node.left &= ~(1U << place % lanes);
        if (node.left != 0) {
            return;
        }
        place /= lanes;
    }
}

}  // namespace lamella::nesting
