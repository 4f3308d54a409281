#include "slicing/regions/snap_rounding.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <numeric>
#include <utility>

#include "base/numbers.hpp"
#include "base/sort.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

namespace {

// Of the search by boxes: where it takes more, most boxes that meet have edges that do not.
constexpr std::uint64_t steps_of_edge = 256;
constexpr std::uint64_t steps_of_contact = 8;
constexpr std::size_t strand_work = 24;  ///< as StopPace counts it; memory is not read in order

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

/// True if both `c` and `d` lie on one side of the line through `a` and `b`, more than rounding_reach from it. In double
/// precision, with room for its rounding: products of 32 bits and 32 have an error of at most 2^11.
bool are_apart(Point a, Point b, Point c, Point d) noexcept {
    constexpr double room = 1 << 13;
    const double dx = static_cast<double>(b.x) - a.x;
    const double dy = static_cast<double>(b.y) - a.y;
    const double of_c = dx * (static_cast<double>(c.y) - a.y) - dy * (static_cast<double>(c.x) - a.x);
    const double of_d = dx * (static_cast<double>(d.y) - a.y) - dy * (static_cast<double>(d.x) - a.x);
    const double most = rounding_reach * (std::abs(dx) + std::abs(dy)) + room;
    return (of_c > most && of_d > most) || (of_c < -most && of_d < -most);
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
    pairs_.clear();
    meets_.assign(contours.size(), 0);
    crossings_.clear();
    first_edges_.clear();
    first_edges_.push_back(0);
    any_meets_ = false;
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        worker_.spend(contours[c].count);
        pairs_.add({{contours[c].points, contours[c].count}, c, true, contours[c].start});
        first_edges_.push_back(first_edges_.back() + contours[c].count);
    }
    near_.assign(first_edges_.back(), {});
    const auto meet_next = [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
        pairs_.allow(meet(a, i, b, j) ? steps_of_contact : 0);
    };
    if (!pairs_.find(rounding_reach, steps_of_edge * pairs_.edges(), meet_next)) {
        slabs_.find(pairs_, pairs_.by_path(meet_next));
    }
    for (const EdgePath& path : pairs_.paths()) {
        if (meets_[path.contour] != 0) {
            mark_sharp_corners(path);
        }
    }
}

/// Where an edge runs back along the one before, so near that either may be bent through an end of the other.
void Contacts::mark_sharp_corners(const EdgePath& path) {
    worker_.spend(path.edges());
    for (std::size_t i = 0; i < path.edges(); ++i) {
        const Point from = pairs_.point(path, i);
        const Point joint = pairs_.point(path, i + 1);
        const Point to = pairs_.point(path, i + 2);
        if (turns_back(from, joint, to) &&
            (is_near(from, joint, to, rounding_reach) || is_near(to, from, joint, rounding_reach))) {
            near_at(path, i) = {true, true};
            near_at(path, i + 1) = {true, true};
            near_at(path, i + 2).point = true;
        }
    }
}

bool Contacts::meet(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const bool same = a.contour == b.contour;
    const Point a0 = pairs_.point(a, i);
    const Point a1 = pairs_.point(a, i + 1);
    const Point b0 = pairs_.point(b, j);
    const Point b1 = pairs_.point(b, j + 1);
    if (same && ((i + 1) % a.edges() == j || (j + 1) % a.edges() == i)) {
        if ((a1 == b0 && runs_back(a0, a1, b1)) || (b1 == a0 && runs_back(b0, b1, a1))) {
            mark(a, i, true, true);
            mark(b, j, true, true);
        }
        return false;
    }
    if (are_apart(a0, a1, b0, b1) || are_apart(b0, b1, a0, a1)) {
        return false;
    }
    const bool crossing = edges_cross(a0, a1, b0, b1);
    const EndsNear of_a = mark_ends(a, i, b0, b1);
    const EndsNear of_b = mark_ends(b, j, a0, a1);
    if (!crossing && !of_a.any && !of_b.any) {
        return false;
    }
    const auto touch = [&] {
        return is_near(a0, b0, b1, 0) || is_near(a1, b0, b1, 0) || is_near(b0, a0, a1, 0) || is_near(b1, a0, a1, 0);
    };
    const bool meets = !same || crossing || touch();
    const bool bends = crossing || of_a.between || of_b.between;
    mark(a, i, meets, bends);
    mark(b, j, meets, bends);
    if (crossing) {
        crossings_.push_back(rounded_crossing(a0, a1, b0, b1));
    }
    return true;
}

void Contacts::mark(const EdgePath& path, std::size_t edge, bool meets, bool bends) noexcept {
    Nearness& near = near_at(path, edge);
    near.edge = near.edge || bends;
    meets_[path.contour] |= meets ? 1 : 0;
    any_meets_ = any_meets_ || meets;
}

/// Marks the ends of an edge that come near the one from `a` to `b`.
Contacts::EndsNear Contacts::mark_ends(const EdgePath& path, std::size_t edge, Point a, Point b) noexcept {
    EndsNear ends;
    for (const std::size_t end : {edge, edge + 1}) {
        const Point p = pairs_.point(path, end);
        if (is_near(p, a, b, rounding_reach)) {
            near_at(path, end).point = true;
            ends.any = true;
            ends.between = ends.between || (p != a && p != b);
        }
    }
    return ends;
}

namespace {

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

/// Two edges that cross beside one that joins them may do so within its reach, and neither is compared with it.
bool SnapRounding::Source::may_bend(std::uint32_t edge) const noexcept {
    const auto count = static_cast<std::uint32_t>(near.size());
    return near[edge].edge || (near[edge > 0 ? edge - 1 : count - 1].edge && near[edge + 1 < count ? edge + 1 : 0].edge);
}

void SnapRounding::run(std::span<const Point> crossings) {
    strands_.clear();
    any_cancelled_ = false;
    collect_vertices(crossings);
    tree_.assign(vertices_.size(), [this](std::size_t i) { return vertices_[i]; });
    strands_.reserve(4 * vertices_.size());  // copying many strands for room would keep a stop waiting
    for (std::uint32_t c = 0; c < contours_.size(); ++c) {
        add_strands_of(c);
    }
    merge_strands();
}

/// A contour's start is one too: of a component, the point farthest to the left.
void SnapRounding::collect_vertices(std::span<const Point> crossings) {
    vertices_.assign(crossings.begin(), crossings.end());
    for (const Source& source : contours_) {
        worker_.spend(source.near.size());
        for (std::uint32_t e = 0; e < source.near.size(); ++e) {
            if (e == 0 || source.near[e].point) {
                vertices_.push_back(source.from(e));
            }
        }
    }
    sort_briefly(vertices_.begin(), vertices_.end(), [this](const Point& a, const Point& b) {
        worker_.spend(1);
        return a < b;
    });
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
}

std::uint32_t SnapRounding::vertex_at(Point p) const noexcept {
    return static_cast<std::uint32_t>(std::lower_bound(vertices_.begin(), vertices_.end(), p) - vertices_.begin());
}

void SnapRounding::add_strands_of(std::uint32_t contour) {
    const Source& source = contours_[contour];
    const auto count = static_cast<std::uint32_t>(source.near.size());
    const Stop start{vertex_at(source.from(0)), 0, true};
    Stop last = start;
    const auto stop_at = [&](const Stop& next) {
        add_strand(contour, last, next);
        last = next;
    };
    for (std::uint32_t e = 0; e < count; ++e) {
        if (e > 0 && source.near[e].point) {
            stop_at({vertex_at(source.from(e)), e, true});
        }
        if (source.may_bend(e)) {
            find_passed(source.from(e), source.to(e));
            for (const Found& found : on_edge_) {
                stop_at({found.vertex, e, false});
            }
        }
    }
    stop_at({start.vertex, count, true});
}

/// Lists the vertices, but for `a` and `b`, of pixels that the edge between them passes. No strand lies on one more: pixels
/// are convex, so that an edge that passes those of two vertices passes that of every vertex on the line between them.
void SnapRounding::find_passed(Point a, Point b) {
    on_edge_.clear();
    tree_.find_along(a, b, [&](Point p, std::uint32_t vertex) {
        worker_.spend(1);
        if (p != a && p != b && passes_pixel(a, b, p)) {
            on_edge_.push_back({p, vertex});
        }
    });
    sort_briefly(on_edge_.begin(), on_edge_.end(), Along(a, b));
}

/// A contour that comes from a vertex over one point back to it encloses nothing.
void SnapRounding::add_strand(std::uint32_t contour, const Stop& from, const Stop& to) {
    const Source& source = contours_[contour];
    const std::uint32_t edges = to.edge - from.edge + (to.at_begin ? 0 : 1);
    if (edges == 1) {
        add_straight(source, from.vertex, to.vertex,
                     stretch_of(source.item->origin_from_start(from.edge), from.at_begin, to.at_begin));
    } else if (edges == 2 && from.vertex == to.vertex) {
        any_cancelled_ = true;
    } else {
        strands_.push_back(
            {from.vertex, to.vertex, source.times, contour, from.edge, edges, source.item->part, PointOrigin()});
    }
}

void SnapRounding::add_straight(const Source& source, std::uint32_t from, std::uint32_t to, const PointOrigin& origin) {
    if (from < to) {
        strands_.push_back({from, to, source.times, 0, 0, 1, source.item->part, origin});
    } else {
        strands_.push_back({to, from, -source.times, 0, 0, 1, source.item->part, turned(origin)});
    }
}

/// Straight strands by their ends, then chains: counted by the vertex that they leave first, of which each has few.
void SnapRounding::sort_strands() {
    first_strands_.assign(vertices_.size() + 1, 0);
    worker_.in_stretches(0, strands_.size(), strand_work, [this](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            first_strands_[strands_[s].from + 1] += strands_[s].is_chain() ? 0 : 1;
        }
    });
    std::partial_sum(first_strands_.begin(), first_strands_.end(), first_strands_.begin());
    next_strands_.assign(first_strands_.begin(), first_strands_.end());
    sorted_.resize(strands_.size());
    std::size_t chain = first_strands_.back();
    worker_.in_stretches(0, strands_.size(), strand_work, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            sorted_[strands_[s].is_chain() ? chain++ : next_strands_[strands_[s].from]++] = strands_[s];
        }
    });
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        sort_briefly(sorted_.begin() + first_strands_[v], sorted_.begin() + first_strands_[v + 1],
                     [](const Strand& a, const Strand& b) { return a.to < b.to; });
        worker_.spend(1 + first_strands_[v + 1] - first_strands_[v]);
    }
    strands_.swap(sorted_);
}

/// Straight strands between the same vertices become one. A chain is the only one of its kind.
void SnapRounding::merge_strands() {
    const auto ends = [](const Strand& strand) { return std::uint64_t{strand.from} << 32 | strand.to; };
    sort_strands();
    const auto chains = strands_.begin() + first_strands_.back();
    auto kept = strands_.begin();
    for (auto next = strands_.begin(); next != strands_.end();) {
        worker_.spend(1);
        Strand strand = *next++;
        for (; next < chains && ends(*next) == ends(strand); ++next) {
            strand.part = part_of_both(strand.part, next->part);
            strand.origin = origin_of_both(strand.origin, next->origin);
            strand.times += next->times;
        }
        if (strand.times != 0) {
            *kept++ = strand;
        }
        any_cancelled_ = any_cancelled_ || strand.times == 0;
    }
    strands_.erase(kept, strands_.end());
}

}  // namespace lamella
