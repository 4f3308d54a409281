#include "slicing/simplify/chain_tree.hpp"

#include <algorithm>

#include "slicing/simplify/edge_tests.hpp"

namespace lamella {

namespace {

constexpr std::size_t leaf_edges = 8;
constexpr std::uint64_t box_steps = 3;  ///< eight boxes are compared at once; an edge takes one

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
    const std::size_t edges = points.size() - std::min<std::size_t>(points.size(), 1);
    const auto box_at = [&](std::size_t leaf) {
        const std::size_t begin = leaf * leaf_edges;
        return FlatBox::around(points.subspan(begin, std::min(leaf_edges, edges - begin) + 1));
    };
    boxes_.assign((edges + leaf_edges - 1) / leaf_edges, box_at, pace);
}

bool ChainTree::encloses(std::size_t first, std::size_t last, Point p, std::uint64_t& steps) const {
    if (p == points_[first] || p == points_[last]) {
        return false;
    }
    Query query{first, last, p};
    visit(boxes_.levels() - 1, 0, query);
    steps += query.steps;
    return query.on_chain || query.winding + winding_of(points_[last], points_[first], p) != 0;
}

/// The boxes of a block, as deep as there are levels.
void ChainTree::visit(std::size_t level, std::size_t number, Query& query) const {
    const std::size_t edges_of_box = leaf_edges << (3 * level);
    const LaneBits holds = boxes_.block(level, number).meets({query.p, query.p});
    for (std::size_t lane = 0; lane < BoxTree<Point>::fan && !query.on_chain; ++lane) {
        const std::size_t begin = (number * BoxTree<Point>::fan + lane) * edges_of_box;
        const std::size_t end = std::min(begin + edges_of_box, points_.size() - 1);
        if (end <= query.first || begin >= query.last) {
            continue;
        }
        query.steps += box_steps;
        const bool is_whole = query.first <= begin && end <= query.last;
        if (is_whole && (holds >> lane & 1) == 0) {
            query.winding += winding_of(points_[begin], points_[end], query.p);
        } else if (level > 0) {
            visit(level - 1, number * BoxTree<Point>::fan + lane, query);
        } else {
            visit_edges(std::max(begin, query.first), std::min(end, query.last), query);
        }
    }
}

void ChainTree::visit_edges(std::size_t begin, std::size_t end, Query& query) const {
    query.steps += leaf_edges;
    for (std::size_t i = begin; i < end; ++i) {
        query.on_chain = query.on_chain || lies_on(query.p, points_[i], points_[i + 1]);
        query.winding += winding_of(points_[i], points_[i + 1], query.p);
    }
}

}  // namespace lamella
