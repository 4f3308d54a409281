#include "slicing/simplify/chain_tree.hpp"

#include <algorithm>

#include "slicing/simplify/edge_tests.hpp"

namespace lamella {

namespace {

constexpr std::size_t leaf_edges = 8;
constexpr std::uint64_t box_steps = 4;  ///< an edge takes one

FlatBox around_both(const FlatBox& a, const FlatBox& b) noexcept {
    return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)},
            {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)}};
}

}  // namespace

struct ChainTree::Query {
    std::size_t first;
    std::size_t last;
    Point p;
    std::uint64_t steps = 0;
    int winding = 0;
    bool on_chain = false;
};

void ChainTree::build(std::span<const Point> points, StopPace& pace) {
    points_ = points;
    boxes_.clear();
    levels_.assign(1, 0);
    const std::size_t edges = points.size() - std::min<std::size_t>(points.size(), 1);
    for (std::size_t begin = 0; begin < edges; begin += leaf_edges) {
        const std::size_t end = std::min(begin + leaf_edges, edges);
        FlatBox box{points[begin], points[begin]};
        for (std::size_t i = begin + 1; i <= end; ++i) {
            box = around_both(box, {points[i], points[i]});
        }
        boxes_.push_back(box);
        pace.spend(leaf_edges);
    }
    levels_.push_back(boxes_.size());
    while (levels_.back() - levels_[levels_.size() - 2] > 1) {
        const std::size_t end = levels_.back();
        for (std::size_t i = levels_[levels_.size() - 2]; i < end; i += 2) {
            boxes_.push_back(i + 1 < end ? around_both(boxes_[i], boxes_[i + 1]) : boxes_[i]);
            pace.spend(1);
        }
        levels_.push_back(boxes_.size());
    }
}

bool ChainTree::encloses(std::size_t first, std::size_t last, Point p, std::uint64_t& steps) const {
    if (p == points_[first] || p == points_[last]) {
        return false;
    }
    Query query{first, last, p};
    visit(levels_.size() - 2, 0, query);
    steps += query.steps;
    return query.on_chain || query.winding + winding_of(points_[last], points_[first], p) != 0;
}

/// As deep as there are levels.
void ChainTree::visit(std::size_t level, std::size_t at, Query& query) const {
    const std::size_t begin = at * (leaf_edges << level);
    const std::size_t end = std::min(begin + (leaf_edges << level), points_.size() - 1);
    if (end <= query.first || begin >= query.last || query.on_chain) {
        return;
    }
    query.steps += box_steps;
    const bool is_whole = query.first <= begin && end <= query.last;
    if (is_whole && !holds(boxes_[levels_[level] + at], query.p)) {
        query.winding += winding_of(points_[begin], points_[end], query.p);
    } else if (level > 0) {
        visit(level - 1, 2 * at, query);
        visit(level - 1, 2 * at + 1, query);
    } else {
        query.steps += leaf_edges;
        for (std::size_t i = std::max(begin, query.first); i < std::min(end, query.last); ++i) {
            query.on_chain = query.on_chain || lies_on(query.p, points_[i], points_[i + 1]);
            query.winding += winding_of(points_[i], points_[i + 1], query.p);
        }
    }
}

}  // namespace lamella
