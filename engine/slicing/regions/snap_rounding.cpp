#include "slicing/regions/snap_rounding.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>
#include <utility>

#include "base/numbers.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/grid/origins.hpp"

namespace lamella {

namespace {

constexpr std::size_t query_work = 64;  ///< as StopPace counts it
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

void SnapRounding::bend(const Source& source, std::uint32_t edge) {
    const Point a = source.from(edge);
    const Point b = source.to(edge);
    on_edge_.clear();
    bool moved = false;
    tree_.find_along(a, b, [&](Point p, std::uint32_t vertex) {
        worker_.spend(1);
        if (p == a || p == b || passes_pixel(a, b, p)) {
            on_edge_.push_back({p, vertex});
            moved = moved || side_of(a, b, p) != 0;
        }
    });
    worker_.spend(query_work);
    std::sort(on_edge_.begin(), on_edge_.end(), Along(a, b));
    assert(on_edge_.size() >= 2 && on_edge_.front().point == a && on_edge_.back().point == b);
    const PointOrigin whole = source.item->origin_from_start(edge);
    for (std::size_t i = 0; i + 1 < on_edge_.size(); ++i) {
        const PointOrigin origin = stretch_of(whole, i == 0, i + 2 == on_edge_.size());
        if (moved) {
            cut(source, on_edge_[i], on_edge_[i + 1], origin);
        } else {
            add_strand(source, on_edge_[i].vertex, on_edge_[i + 1].vertex, origin);
        }
    }
}

/// Cuts a strand that was moved where it now lies on a vertex.
void SnapRounding::cut(const Source& source, const Found& from, const Found& to, const PointOrigin& origin) {
    on_strand_.clear();
    tree_.find_along(from.point, to.point, [&](Point p, std::uint32_t vertex) {
        if (p != from.point && p != to.point && side_of(from.point, to.point, p) == 0) {
            on_strand_.push_back({p, vertex});
        }
    });
    worker_.spend(query_work);
    std::sort(on_strand_.begin(), on_strand_.end(), Along(from.point, to.point));
    std::uint32_t last = from.vertex;
    bool is_first = true;
    for (const Found& on : on_strand_) {
        add_strand(source, last, on.vertex, stretch_of(origin, std::exchange(is_first, false), false));
        last = on.vertex;
    }
    add_strand(source, last, to.vertex, stretch_of(origin, is_first, true));
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

void SnapRounding::append_points_within(const Strand& chain, bool backwards, Vector<Point>& points) const {
    const NestItem& item = *contours_[chain.contour].item;
    const std::size_t within = chain.edges - 1;
    const std::size_t first = (std::size_t{item.start} + chain.first + 1) % item.count;
    const std::size_t before_wrap = std::min(within, item.count - first);
    const std::size_t begin = points.size();
    points.resize(begin + within);
    Point* const to = points.data() + begin;
    if (backwards) {
        std::reverse_copy(item.points + first, item.points + first + before_wrap, to + (within - before_wrap));
        std::reverse_copy(item.points, item.points + (within - before_wrap), to);
    } else {
        std::copy_n(item.points + first, before_wrap, to);
        std::copy_n(item.points, within - before_wrap, to + before_wrap);
    }
}

}  // namespace lamella
