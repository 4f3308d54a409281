// Ear clipping in the order of a Graham scan (Kong, Everett, Toussaint 1990): each step either clips the corner that it
// stands on and goes back by one, or goes on, so that a polygon takes about 2n tests for ears. Only corners that are not
// convex can lie in an ear; a tree over them answers each test in about O(log n).
#include "io/read/polygon.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "base/numbers.hpp"

namespace lamella {

namespace {

using Vector = std::array<double, 3>;

constexpr std::uint32_t no_leaf = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t leaf_corners = 8;

/// Steps through the tree after which a polygon is refused: so many a corner, and some for each polygon. A step takes about
/// 10 ns. Real outlines take up to 100 a corner, one of 100,000 random spikes takes 140.
constexpr std::uint64_t most_steps_a_corner = 192;
constexpr std::uint64_t free_steps = std::uint64_t{1} << 17;
/// The cost of a look at both neighbours of a corner.
constexpr std::uint64_t neighbour_steps = 3;

Vector minus(const Vector& a, const Vector& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A sum of doubles kept without rounding: parts of ascending magnitude that do not overlap (Shewchuk 1997, figure 6).
class ExactSum {
public:
    void add_product(double a, double b) {
        const double product = a * b;
        add(std::fma(a, b, -product));
        add(product);
    }
    int sign() const {
        for (std::size_t i = count_; i-- > 0;) {
            if (parts_[i] != 0) {
                return sign_of(parts_[i]);
            }
        }
        return 0;
    }

private:
    void add(double value) {
        for (std::size_t i = 0; i < count_; ++i) {
            const double sum = value + parts_[i];
            const double taken = sum - value;
            parts_[i] = (value - (sum - taken)) + (parts_[i] - taken);
            value = sum;
        }
        parts_[count_++] = value;
    }

    std::array<double, 12> parts_{};  // of six products
    std::size_t count_ = 0;
};

/// 1 where a, b, c turn left, -1 where right, 0 where they are collinear; exact unless numbers beyond 1e150 overflow.
template <class A, class B, class C>
int turn(const A& a, const B& b, const C& c) {
    // Shewchuk's bound of the rounding errors of this difference: (3 + 16 e) e with e = 2^-53.
    constexpr double error_bound = 3.3306690738754716e-16;
    const double left = (a.x - c.x) * (b.y - c.y);
    const double right = (a.y - c.y) * (b.x - c.x);
    const double area = left - right;
    if (std::abs(area) > error_bound * (std::abs(left) + std::abs(right))) {
        return sign_of(area);
    }
    if ((a.x == c.x || b.y == c.y) && (a.y == c.y || b.x == c.x)) {
        return 0;  // the most common of the undecided: two in one place, or all on a line along an axis
    }
    ExactSum sum;
    sum.add_product(a.x, b.y);
    sum.add_product(-a.x, c.y);
    sum.add_product(-c.x, b.y);
    sum.add_product(-a.y, b.x);
    sum.add_product(a.y, c.x);
    sum.add_product(c.y, b.x);
    return sum.sign();
}

template <class A, class B>
bool same_place(const A& a, const B& b) {
    return a.x == b.x && a.y == b.y;
}

/// Twice the area vector, of Newell.
Vector area_of(std::span<const std::uint32_t> corners, const VertexCoordinates& vertices) {
    const Vector origin = vertices[corners[0]];
    Vector area{};
    Vector last{};
    for (const std::uint32_t corner : corners.subspan(1)) {
        const Vector here = minus(vertices[corner], origin);
        const Vector part = cross(last, here);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            area[axis] += part[axis];
        }
        last = here;
    }
    return area;
}

}  // namespace

bool splits_at_first(std::span<const std::uint32_t> quad, const VertexCoordinates& vertices) {
    const Vector first = vertices[quad[0]];
    const Vector diagonal = minus(vertices[quad[2]], first);
    const double product =
        dot(cross(minus(vertices[quad[1]], first), diagonal), cross(diagonal, minus(vertices[quad[3]], first)));
    return product > 0 && product <= std::numeric_limits<double>::max();
}

std::size_t fan(std::span<const std::uint32_t> corners, std::uint32_t* out) {
    for (std::size_t i = 2; i < corners.size(); ++i) {
        *out++ = corners[0];
        *out++ = corners[i - 1];
        *out++ = corners[i];
    }
    return corners.size() - 2;
}

std::size_t PolygonTriangulator::triangulate(std::span<const std::uint32_t> corners, const VertexCoordinates& vertices,
                                             std::uint32_t* out) {
    assert(corners.size() >= 3);
    if (corners.size() == 3 || (corners.size() == 4 && splits_at_first(corners, vertices))) {
        return fan(corners, out);
    }
    if (corners.size() >= no_leaf) {
        return 0;  // corners are numbered by 32 bits
    }
    project(corners, vertices);
    if (is_convex()) {
        return fan(corners, out);
    }
    return clip_ears(corners, out) ? corners.size() - 2 : 0;
}

/// Drops the axis next to the normal, so that coordinates stay the file's own and the polygon runs counter-clockwise.
void PolygonTriangulator::project(std::span<const std::uint32_t> corners, const VertexCoordinates& vertices) {
    const Vector area = area_of(corners, vertices);
    std::size_t dropped = 2;
    for (const std::size_t axis : {0U, 1U}) {
        dropped = std::abs(area[axis]) > std::abs(area[dropped]) ? axis : dropped;
    }
    std::size_t x = (dropped + 1) % 3;
    std::size_t y = (dropped + 2) % 3;
    if (area[dropped] < 0) {
        std::swap(x, y);
    }
    const auto count = static_cast<std::uint32_t>(corners.size());
    corners_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Vector at = vertices[corners[i]];
        corners_[i] = {at[x], at[y], i == 0 ? count - 1 : i - 1, i + 1 == count ? 0 : i + 1};
    }
}

bool PolygonTriangulator::turns_left(std::uint32_t corner) const {
    const Corner& b = corners_[corner];
    return turn(corners_[b.previous], b, corners_[b.next]) > 0;
}

/// Strictly convex: every corner turns left, and the edges go once to the right and once back.
bool PolygonTriangulator::is_convex() const {
    const auto goes_right = [this](const Corner& from) {
        const Corner& to = corners_[from.next];
        return to.x > from.x || (to.x == from.x && to.y > from.y);
    };
    int reversals = 0;
    for (std::uint32_t i = 0; i < corners_.size(); ++i) {
        reversals += static_cast<int>(goes_right(corners_[i]) != goes_right(corners_[corners_[i].next]));
        if (reversals > 2 || !turns_left(i)) {
            return false;
        }
    }
    return true;
}

bool PolygonTriangulator::clip_ears(std::span<const std::uint32_t> corners, std::uint32_t* out) {
    build_tree();
    const std::uint64_t most_steps = free_steps + most_steps_a_corner * corners.size();
    steps_ = 0;
    std::uint32_t at = 0;
    std::size_t left = corners.size();
    for (const Rule rule : {Rule::untouched, Rule::nothing_within, Rule::convex, Rule::any}) {
        for (std::size_t in_vain = 0; left > 3 && in_vain < left;) {
            const Corner here = corners_[at];
            if (++steps_ > most_steps) {
                return false;
            }
            if (!is_ear(at, rule)) {
                at = here.next;
                ++in_vain;
                continue;
            }
            *out++ = corners[here.previous];
            *out++ = corners[at];
            *out++ = corners[here.next];
            corners_[here.previous].next = here.next;
            corners_[here.next].previous = here.previous;
            for (const std::uint32_t changed : {here.previous, here.next}) {
                if (leaf_of_[changed] != no_leaf && turns_left(changed)) {
                    forget(changed);
                }
            }
            forget(at);
            at = here.previous;
            --left;
            in_vain = 0;
        }
    }
    assert(left == 3);
    *out++ = corners[corners_[at].previous];
    *out++ = corners[at];
    *out++ = corners[corners_[at].next];
    return true;
}

bool PolygonTriangulator::is_ear(std::uint32_t corner, Rule rule) {
    return rule == Rule::any || (turns_left(corner) && (rule == Rule::convex || !blocked(corner, rule)));
}

// --- the tree of corners that may block

void PolygonTriangulator::build_tree() {
    blockers_.clear();
    blockers_.reserve(corners_.size());
    leaf_of_.assign(corners_.size(), no_leaf);
    for (std::uint32_t i = 0; i < corners_.size(); ++i) {
        if (!turns_left(i)) {
            blockers_.push_back(i);
        }
    }
    nodes_.clear();
    nodes_.reserve(most_nodes(blockers_.size()));
    nodes_.push_back({.end = static_cast<std::uint32_t>(blockers_.size())});
    for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
        split(node);
    }
}

/// Gives `node` its box, and either two children or its corners.
void PolygonTriangulator::split(std::uint32_t node) {
    Node here = nodes_[node];
    here.alive = here.end - here.begin;
    here.low_x = here.low_y = std::numeric_limits<double>::infinity();
    here.high_x = here.high_y = -std::numeric_limits<double>::infinity();
    for (std::uint32_t i = here.begin; i < here.end; ++i) {
        const Corner& corner = corners_[blockers_[i]];
        here.low_x = std::min(here.low_x, corner.x);
        here.low_y = std::min(here.low_y, corner.y);
        here.high_x = std::max(here.high_x, corner.x);
        here.high_y = std::max(here.high_y, corner.y);
    }
    if (here.alive > leaf_corners) {
        const bool by_x = here.high_x - here.low_x > here.high_y - here.low_y;
        const std::uint32_t middle = here.begin + here.alive / 2;
        std::nth_element(blockers_.begin() + here.begin, blockers_.begin() + middle, blockers_.begin() + here.end,
                         [this, by_x](std::uint32_t a, std::uint32_t b) {
                             return by_x ? corners_[a].x < corners_[b].x : corners_[a].y < corners_[b].y;
                         });
        here.children = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({.begin = here.begin, .end = middle, .parent = node});
        nodes_.push_back({.begin = middle, .end = here.end, .parent = node});
    } else {
        for (std::uint32_t i = here.begin; i < here.end; ++i) {
            leaf_of_[blockers_[i]] = node;
        }
    }
    nodes_[node] = here;
}

/// Takes `corner` from the tree: it was clipped or became convex.
void PolygonTriangulator::forget(std::uint32_t corner) {
    std::uint32_t node = std::exchange(leaf_of_[corner], no_leaf);
    if (node == no_leaf) {
        return;
    }
    for (--nodes_[node].alive; node != 0; --nodes_[node].alive) {
        node = nodes_[node].parent;
    }
}

bool PolygonTriangulator::blocked(std::uint32_t corner, Rule rule) {
    const Corner& b = corners_[corner];
    const Corner& a = corners_[b.previous];
    const Corner& c = corners_[b.next];
    open_.assign(1, 0);
    while (!open_.empty()) {
        const Node& node = nodes_[open_.back()];
        open_.pop_back();
        ++steps_;
        const bool one_place = node.low_x == node.high_x && node.low_y == node.high_y;
        const Corner place{node.low_x, node.low_y};
        if (node.alive == 0 || misses(node, a, b, c) || (one_place && (same_place(place, a) || same_place(place, c)))) {
            continue;  // the ends of a diagonal block nothing; many corners may lie there
        }
        if (node.children != 0) {
            open_.push_back(node.children);
            open_.push_back(node.children + 1);
            continue;
        }
        steps_ += (one_place && same_place(place, b) ? neighbour_steps : 1) * node.alive;
        for (std::uint32_t i = node.begin; i < node.end; ++i) {
            if (leaf_of_[blockers_[i]] != no_leaf && blocks(blockers_[i], corner, rule)) {
                return true;
            }
        }
    }
    return false;
}

/// True if the box lies beside the triangle: to one side of it, or right of one of its edges as a whole.
bool PolygonTriangulator::misses(const Node& node, const Corner& a, const Corner& b, const Corner& c) const {
    if (node.high_x < std::min({a.x, b.x, c.x}) || node.low_x > std::max({a.x, b.x, c.x}) ||
        node.high_y < std::min({a.y, b.y, c.y}) || node.low_y > std::max({a.y, b.y, c.y})) {
        return true;
    }
    const auto right_of = [&node](const Corner& from, const Corner& to) {
        // The box's corner that lies farthest to the left of the edge.
        const Corner farthest{to.y > from.y ? node.low_x : node.high_x, to.x > from.x ? node.high_y : node.low_y};
        return turn(from, to, farthest) < 0;
    };
    return right_of(a, b) || right_of(b, c) || right_of(c, a);
}

/// True if `corner` keeps `ear` from being clipped.
bool PolygonTriangulator::blocks(std::uint32_t corner, std::uint32_t ear, Rule rule) const {
    const Corner& p = corners_[corner];
    const Corner& b = corners_[ear];
    const Corner& a = corners_[b.previous];
    const Corner& c = corners_[b.next];
    const auto between = [&](const Corner& q) { return turn(a, b, q) > 0 && turn(b, c, q) > 0; };
    if (rule == Rule::nothing_within) {
        return between(p) && turn(c, a, p) > 0;
    }
    if (corner == ear || corner == b.previous || corner == b.next || same_place(p, a) || same_place(p, c)) {
        return false;
    }
    if (same_place(p, b)) {  // the outline returns to this point: on the triangle's side, or from outside
        return between(corners_[p.previous]) || between(corners_[p.next]);
    }
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

}  // namespace lamella
