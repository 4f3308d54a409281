#include "slicing/regions/snap_rounding.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <limits>
#include <tuple>
#include <utility>

#include "base/numbers.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

constexpr std::uint64_t any_number = std::numeric_limits<std::uint64_t>::max();

/// True if the edge from `joint` to `to` leads back, by more than a right angle, from the one from `from` to `joint`.
bool turns_back(Point from, Point joint, Point to) noexcept {
    const std::int64_t along_x = (std::int64_t{joint.x} - from.x) * (std::int64_t{to.x} - joint.x);
    const std::int64_t along_y = (std::int64_t{joint.y} - from.y) * (std::int64_t{to.y} - joint.y);
    return along_x < -along_y;
}

/// True if one of the two edges lies on the other.
bool runs_back(Point from, Point joint, Point to) noexcept {
    return side_of(from, joint, to) == 0 && turns_back(from, joint, to);
}

/// value / (2 * divisor), rounded; halves up.
Int128 rounded_half(Int128 value, Int128 divisor) noexcept {
    const Int128 twice = 2 * divisor;
    const Int128 sum = value + divisor;
    return sum / twice - (sum % twice < 0 ? 1 : 0);
}

}  // namespace

bool is_near(Point p, Point a, Point b, std::int32_t reach) noexcept {
    if (!grown(FlatBox::around(a, b), reach).holds(p)) {
        return false;
    }
    const Int128 distance_by_length = side_of_line(a, b, p);
    const std::int64_t length = std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
    const Int128 most = Int128{reach} * length;
    return -most <= distance_by_length && distance_by_length <= most;
}

Point rounded_crossing(Point a, Point b, Point c, Point d) noexcept {
    const std::int64_t dx = std::int64_t{b.x} - a.x;
    const std::int64_t dy = std::int64_t{b.y} - a.y;
    const Int128 c_side = side_of_line(a, b, c);
    const Int128 d_side = side_of_line(a, b, d);
    assert(c_side != d_side);
    Int128 whole = c_side - d_side;  // the crossing is a + (b - a) part / whole
    Int128 part = side_of_line(c, d, a);
    assert(part != 0);
    // side_of_line(c, d, a) - side_of_line(c, d, b) is whole or its opposite: the signs of `part` and `whole` must agree.
    if (part < 0) {
        part = -part;
    }
    if (whole < 0) {
        whole = -whole;
    }
    return {static_cast<std::int32_t>(a.x + rounded_half(2 * part * dx, whole)),
            static_cast<std::int32_t>(a.y + rounded_half(2 * part * dy, whole))};
}

void Contacts::find(std::span<const NestItem> contours) {
    near_.clear();
    meets_.assign(contours.size(), 0);
    crossings_.clear();
    first_edges_.clear();
    first_edges_.push_back(0);
    any_meets_ = false;
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        worker_.spend(contours[c].count);
        near_.add({{contours[c].points, contours[c].count}, c, true, contours[c].start});
        first_edges_.push_back(first_edges_.back() + contours[c].count);
    }
    near_edges_.assign(first_edges_.back(), 0);
    near_.find(rounding_reach, any_number,
               [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) { meet(a, i, b, j); });
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (meets(c)) {
            mark_sharp_corners(contours[c], c);
        }
    }
}

/// Where an edge runs back along the one before, so near that either may be bent through an end of the other.
void Contacts::mark_sharp_corners(const NestItem& contour, std::uint32_t number) {
    const std::span<std::uint8_t> near = std::span(near_edges_).subspan(first_edges_[number], contour.count);
    worker_.spend(contour.count);
    for (std::uint32_t i = 0; i < contour.count; ++i) {
        const Point from = contour.from_start(i);
        const Point joint = contour.from_start(i + 1);
        const Point to = contour.from_start(i + 2);
        if (turns_back(from, joint, to) &&
            (is_near(from, joint, to, rounding_reach) || is_near(to, from, joint, rounding_reach))) {
            near[i] = near[i + 1 < contour.count ? i + 1 : 0] = 1;
        }
    }
}

void Contacts::meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const bool same = a.contour == b.contour;
    const Point a0 = a[i];
    const Point a1 = a[i + 1];
    const Point b0 = b[j];
    const Point b1 = b[j + 1];
    if (same && ((i + 1) % a.edges() == j || (j + 1) % a.edges() == i)) {
        if ((a1 == b0 && runs_back(a0, a1, b1)) || (b1 == a0 && runs_back(b0, b1, a1))) {
            mark(a, i, true);
            mark(b, j, true);
        }
        return;
    }
    const auto touch = [&](std::int32_t reach) {
        return is_near(a0, b0, b1, reach) || is_near(a1, b0, b1, reach) || is_near(b0, a0, a1, reach) ||
               is_near(b1, a0, a1, reach);
    };
    const bool crossing = edges_cross(a0, a1, b0, b1);
    if (!crossing && !touch(rounding_reach)) {
        return;
    }
    const bool meets = !same || crossing || touch(0);
    mark(a, i, meets);
    mark(b, j, meets);
    if (crossing) {
        crossings_.push_back(rounded_crossing(a0, a1, b0, b1));
    }
}

void Contacts::mark(const EdgePath& path, std::size_t edge, bool meets) noexcept {
    near_edges_[first_edges_[path.contour] + edge] = 1;
    meets_[path.contour] |= meets ? 1 : 0;
    any_meets_ = any_meets_ || meets;
}

namespace {

constexpr std::uint32_t open_end = 0xffffffff;

/// In the direction from `a` to `b`, for points of pixels that the edge meets: it meets them one after the other in x and y.
struct Along {
    bool right;
    bool up;

    Along(Point a, Point b) noexcept : right(a.x <= b.x), up(a.y <= b.y) {}
    template <class Found>
    bool operator()(const Found& p, const Found& q) const noexcept {
        return p.point.x != q.point.x ? (p.point.x < q.point.x) == right
                                      : p.point.y != q.point.y && (p.point.y < q.point.y) == up;
    }
};

}  // namespace

/// In half units, where pixels' sides are odd and ends of edges even. The edge enters the square when it has entered both
/// its x and its y, and leaves when it leaves one: in each comparison of two such moments a product stands for each.
bool passes_pixel(Point a, Point b, Point p) noexcept {
    if (a.x > b.x) {
        std::swap(a, b);
    }
    const std::int64_t left = 2 * std::int64_t{p.x} - 1 - 2 * std::int64_t{a.x};
    const std::int64_t right = left + 2;
    const std::int64_t dx = std::int64_t{b.x} - a.x;
    const std::int64_t dy = std::int64_t{b.y} - a.y;
    if (left > 2 * dx || right <= 0) {
        return false;
    }
    const std::int64_t bottom = 2 * std::int64_t{p.y} - 1 - 2 * std::int64_t{a.y};
    const std::int64_t top = bottom + 2;
    if (dy >= 0) {
        return bottom <= 2 * dy && top > 0 && Int128{left} * dy < Int128{top} * dx &&
               Int128{bottom} * dx < Int128{right} * dy;
    }
    // Downwards the square is entered through its top, which is not part of it, and left after its bottom, which is.
    return top > 2 * dy && bottom <= 0 && Int128{left} * -dy <= Int128{-bottom} * dx &&
           Int128{-top} * dx < Int128{right} * -dy;
}

/// An edge that may move may come to lie on its neighbours.
bool SnapRounding::Source::is_active(std::uint32_t edge) const noexcept {
    const auto count = static_cast<std::uint32_t>(near.size());
    return near[edge] != 0 || near[edge > 0 ? edge - 1 : count - 1] != 0 || near[edge + 1 < count ? edge + 1 : 0] != 0;
}

void SnapRounding::run(std::span<const Point> crossings) {
    strands_.clear();
    collect_vertices(crossings);
    tree_.assign(vertices_.size(), [this](std::size_t i) { return vertices_[i]; });
    strands_.reserve(2 * vertices_.size());  // copying many strands for room would keep a stop waiting
    for (std::uint32_t c = 0; c < contours_.size(); ++c) {
        add_strands_of(c);
    }
    merge_strands();
}

void SnapRounding::collect_vertices(std::span<const Point> crossings) {
    vertices_.assign(crossings.begin(), crossings.end());
    for (const Source& source : contours_) {
        worker_.spend(source.near.size());
        bool active_before = true;  // a contour's start is a vertex
        for (std::uint32_t e = 0; e < source.near.size(); ++e) {
            const bool active = source.is_active(e);
            if (active || active_before) {
                vertices_.push_back(source.from(e));
            }
            active_before = active;
        }
    }
    std::sort(vertices_.begin(), vertices_.end(), [this](const Point& a, const Point& b) {
        worker_.spend(1);
        return a < b;
    });
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
}

void SnapRounding::add_strands_of(std::uint32_t contour) {
    const Source& source = contours_[contour];
    const auto count = static_cast<std::uint32_t>(source.near.size());
    const auto start_place = std::lower_bound(vertices_.begin(), vertices_.end(), source.from(0));
    const auto start = static_cast<std::uint32_t>(start_place - vertices_.begin());
    std::uint32_t reached = start;
    std::size_t chain = strands_.size();  // the one that has no end yet
    bool in_chain = false;
    for (std::uint32_t e = 0; e < count; ++e) {
        if (!source.is_active(e)) {
            if (!in_chain) {
                chain = strands_.size();
                strands_.push_back(
                    {reached, open_end, source.times, contour, e, 0, source.item->part, source.item->origin_from_start(e)});
                in_chain = true;
            }
            ++strands_[chain].edges;
            continue;
        }
        bend(source, e);
        if (in_chain) {
            strands_[chain].to = on_edge_.front().vertex;
            in_chain = false;
        }
        reached = on_edge_.back().vertex;
    }
    if (in_chain) {
        strands_[chain].to = start;
    }
}

/// The vertices of pixels that an edge passes, in its direction, joined by strands. No strand lies on one more: pixels are
/// convex, so that an edge that passes those of two vertices passes that of every vertex on the line between them.
void SnapRounding::bend(const Source& source, std::uint32_t edge) {
    const Point a = source.from(edge);
    const Point b = source.to(edge);
    on_edge_.clear();
    tree_.find_along(a, b, [&](Point p, std::uint32_t vertex) {
        worker_.spend(1);
        if (p == a || p == b || passes_pixel(a, b, p)) {
            on_edge_.push_back({p, vertex});
        }
    });
    std::sort(on_edge_.begin(), on_edge_.end(), Along(a, b));
    assert(on_edge_.size() >= 2 && on_edge_.front().point == a && on_edge_.back().point == b);
    const PointOrigin whole = source.item->origin_from_start(edge);
    for (std::size_t i = 0; i + 1 < on_edge_.size(); ++i) {
        add_strand(source, on_edge_[i].vertex, on_edge_[i + 1].vertex, stretch_of(whole, i == 0, i + 2 == on_edge_.size()));
    }
}

void SnapRounding::add_strand(const Source& source, std::uint32_t from, std::uint32_t to, const PointOrigin& origin) {
    if (from < to) {
        strands_.push_back({from, to, source.times, 0, 0, 1, source.item->part, origin});
    } else {
        strands_.push_back({to, from, -source.times, 0, 0, 1, source.item->part, turned(origin)});
    }
}

/// Straight strands between the same vertices become one. A chain is the only one of its kind.
void SnapRounding::merge_strands() {
    std::sort(strands_.begin(), strands_.end(), [this](const Strand& a, const Strand& b) {
        worker_.spend(1);
        return std::tuple(a.is_chain(), a.from, a.to, a.contour, a.first) <
               std::tuple(b.is_chain(), b.from, b.to, b.contour, b.first);
    });
    any_cancelled_ = false;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < strands_.size();) {
        worker_.spend(1);
        Strand strand = strands_[i++];
        while (!strand.is_chain() && i < strands_.size() && !strands_[i].is_chain() && strands_[i].from == strand.from &&
               strands_[i].to == strand.to) {
            strand.part = part_of_both(strand.part, strands_[i].part);
            strand.origin = origin_of_both(strand.origin, strands_[i].origin);
            strand.times += strands_[i++].times;
        }
        if (strand.times != 0) {
            strands_[kept++] = strand;
        }
        any_cancelled_ = any_cancelled_ || strand.times == 0;
    }
    strands_.resize(kept);
}

}  // namespace lamella
