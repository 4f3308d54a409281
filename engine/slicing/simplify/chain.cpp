#include "slicing/simplify/chain.hpp"

#include <algorithm>

#include "base/numbers.hpp"

namespace lamella {

namespace {

struct Vector2 {
    std::int64_t x;
    std::int64_t y;
};

constexpr Vector2 between(Point from, Point to) noexcept {
    return {std::int64_t{to.x} - from.x, std::int64_t{to.y} - from.y};
}

/// At most 2^63, which the grid's diagonal has.
constexpr std::uint64_t square(Vector2 v) noexcept {
    return static_cast<std::uint64_t>(v.x * v.x) + static_cast<std::uint64_t>(v.y * v.y);
}

/// True if the two point the same way by less than a right angle. The sum of the products could take 65 bits.
constexpr bool leads_along(Vector2 u, Vector2 v) noexcept {
    return u.x * v.x > -(u.y * v.y);
}

/// Twice the area of a triangle: at most the square of the grid's side, 2^62.
constexpr std::uint64_t distance_by_length(Vector2 line, Vector2 to) noexcept {
    const std::int64_t area = line.x * to.y - line.y * to.x;
    return static_cast<std::uint64_t>(area < 0 ? -area : area);
}

/// The greatest so far, the first of equal ones.
struct Greatest {
    std::uint64_t value = 0;
    std::size_t at = 0;

    void see(std::uint64_t other, std::size_t place) noexcept {
        at = other > value ? place : at;
        value = other > value ? other : value;
    }
};

}  // namespace

/// A point beside the line is as far from it as its triangle with the ends is large; one beyond an end is as far as the end.
/// Those beyond an end, if too far, are split off first: they are where the chain leads back.
ChainReach measure_chain(const Point* points, std::size_t first, std::size_t last, std::int64_t tolerance) noexcept {
    const Point a = points[first];
    const Point b = points[last];
    const Vector2 line = between(a, b);
    Greatest beside;
    Greatest beyond;
    for (std::size_t i = first + 1; i < last; ++i) {
        const Vector2 from_a = between(a, points[i]);
        const Vector2 from_b = between(b, points[i]);
        if (!leads_along(from_a, line)) {
            beyond.see(square(from_a), i);
        } else if (leads_along(from_b, line)) {
            beyond.see(square(from_b), i);
        } else {
            beside.see(distance_by_length(line, from_a), i);
        }
    }
    const std::size_t middle = first + (last - first) / 2;
    const Int128 squared = Int128{tolerance} * tolerance;
    if (a == b || Int128{beyond.value} > squared) {
        return {beyond.value > 0 ? beyond.at : middle, false};
    }
    const bool within = Int128{beside.value} * beside.value <= squared * square(line);  // at most 2^124 and 2^125
    return {beside.value > 0 ? beside.at : middle, within};
}

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
