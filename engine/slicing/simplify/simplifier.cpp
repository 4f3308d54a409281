#include "slicing/simplify/simplifier.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <limits>
#include <new>

#include "base/sort.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/nesting/order.hpp"

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

/// True if what has that distance times the length of `line` lies within the tolerance of it.
bool is_beside(std::uint64_t distance_by_length, Vector2 line, std::int64_t tolerance) noexcept {
    return Int128{distance_by_length} * distance_by_length <= Int128{tolerance} * tolerance * square(line);  // 2^124, 2^125
}

bool lies_on(Point p, Point a, Point b) noexcept {
    return FlatBox::around(a, b).holds(p) && side_of(a, b, p) == 0;
}

/// True if two edges have a point in common.
bool have_common_point(Point a, Point b, Point c, Point d) noexcept {
    return edges_cross(a, b, c, d) || lies_on(a, c, d) || lies_on(b, c, d) || lies_on(c, a, b) || lies_on(d, a, b);
}

/// True if one of two edges that follow each other lies on the other.
bool folds_back(Point from, Point joint, Point to) noexcept {
    return lies_on(from, joint, to) || lies_on(to, from, joint);
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

/// Measured over the points strictly between the ends of a chain.
struct ChainReach {
    std::size_t furthest;  ///< index of one to keep, should the chain be split
    bool within;           ///< all lie within the tolerance of the line between the ends
};

/// Measures points[first] to points[last], last > first + 1. Distances are to the line from end to end, which stops there; a
/// line between equal ends replaces nothing. `tolerance` is in grid units, at most 2 grid_limit. O(last - first).
///
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
    if (a == b || Int128{beyond.value} > Int128{tolerance} * tolerance) {
        return {beyond.value > 0 ? beyond.at : middle, false};
    }
    return {beside.value > 0 ? beside.at : middle, is_beside(beside.value, line, tolerance)};
}

constexpr std::size_t chain_work = 4;  ///< of a point, as StopPace counts it
constexpr int rounds_by_distance = 3;  ///< from then on lines are split by halves, which ends soon

/// The most that O(m log m) allows for.
std::uint64_t most_steps(std::uint64_t edges) noexcept {
    constexpr std::uint64_t steps_per_comparison = 64;
    return steps_per_comparison * edges * static_cast<std::uint64_t>(std::bit_width(edges) + 1);
}

}  // namespace

void Simplifier::run(std::span<NestItem> items, std::int64_t tolerance) {
    tolerance_ = tolerance;
    list(items);
    for (Reduction& path : paths_) {
        reduce(path);
    }
    list_left();
    if (std::all_of(paths_.begin(), paths_.end(), [](const Reduction& path) { return path.left == path.count(); })) {
        return;
    }
    starts_tree_.assign(starts_.size(), [this](std::size_t i) { return starts_[i]; });
    for (int round = 1;; ++round) {
        if (!find_conflicts(items)) {
            is_left_.assign(points_.size(), 1);
            list_left();
            return;
        }
        if (!give_back(round)) {
            break;
        }
        list_left();
    }
    write(items);
}

void Simplifier::list(std::span<const NestItem> items) {
    paths_.clear();
    points_.clear();
    starts_.clear();
    for (const NestItem& item : items) {
        const std::size_t begin = points_.size();
        points_.insert(points_.end(), item.points + item.start, item.points + item.count);
        points_.insert(points_.end(), item.points, item.points + item.start);
        starts_.push_back(points_[begin]);
        if (item.closed) {
            points_.push_back(points_[begin]);
        }
        const bool is_flat = item.closed && to_int128(item.twice_area) == 0;
        paths_.push_back({.begin = begin,
                          .last = points_.size() - 1,
                          .closed = item.closed,
                          .stays = is_flat || item.count <= (item.closed ? 3U : 2U)});
        worker_.spend(item.count);
    }
    if (points_.size() > std::numeric_limits<Index>::max()) {
        throw std::bad_alloc();
    }
    is_left_.assign(points_.size(), 0);
    in_conflict_.assign(points_.size(), 0);
}

/// A closed path is two chains: from its start to the point that is furthest from there, and back.
void Simplifier::reduce(Reduction& path) {
    path.has_changed = !path.stays;
    if (path.stays) {
        std::fill(is_left_.begin() + static_cast<std::ptrdiff_t>(path.begin),
                  is_left_.begin() + static_cast<std::ptrdiff_t>(path.last) + 1, std::uint8_t{1});
        return;
    }
    is_left_[path.begin] = is_left_[path.last] = 1;
    reduce_chain(path.begin, path.last);
}

void Simplifier::reduce_chain(std::size_t first, std::size_t last) {
    reduce_chain(first, last, 2 * static_cast<int>(std::bit_width(last - first)));
}

/// Where the furthest points have peeled off little, chains are halved: O(n log n) for all points of a contour.
void Simplifier::reduce_chain(std::size_t first, std::size_t last, int splits_left) {
    if (last - first < 2) {
        return;
    }
    worker_.spend(chain_work * (last - first));
    const ChainReach reach = measure_chain(points_.data(), first, last, tolerance_);
    if (reach.within) {
        return;
    }
    const std::size_t at = splits_left > 0 ? reach.furthest : first + (last - first) / 2;
    is_left_[at] = 1;
    const int left = std::max(0, splits_left - 1);
    reduce_chain(first, at, left);
    reduce_chain(at, last, left);
}

/// Closed paths without the start that stands at the end.
void Simplifier::list_left() {
    left_.clear();
    left_points_.clear();
    for (Reduction& path : paths_) {
        path.first_left = left_.size();
        const std::size_t end = path.closed ? path.last : path.last + 1;
        worker_.in_stretches(path.begin, end, 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t i = from; i < to; ++i) {
                if (is_left_[i] != 0) {
                    left_.push_back(static_cast<Index>(i - path.begin));
                    left_points_.push_back(points_[i]);
                }
            }
        });
        path.left = left_.size() - path.first_left;
    }
}

/// True if all were found, in no more steps than may be.
bool Simplifier::find_conflicts(std::span<const NestItem> items) {
    pairs_.clear();
    for (std::size_t p = 0; p < paths_.size(); ++p) {
        const Reduction& path = paths_[p];
        pairs_.add(
            {.points = std::span(left_points_).subspan(path.first_left, path.left), .contour = p, .closed = path.closed});
        worker_.spend(path.left);
    }
    const std::uint64_t most = most_steps(points_.size());
    if (!pairs_.find(0, most,
                     [this](const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) { compare(a, i, b, j); })) {
        return false;
    }
    steps_ = 0;
    for (std::size_t p = 0; p < paths_.size() && steps_ <= most; ++p) {
        if (paths_[p].has_changed) {
            find_jumps(p, most);
            keep_orientation(p, items[p]);
            paths_[p].has_changed = false;
        }
    }
    return steps_ <= most;
}

/// True if edge `edge` of what is left of a path replaces points.
bool Simplifier::is_line(std::size_t path, std::size_t edge) const noexcept {
    return end_of_line(path, edge) - left_[paths_[path].first_left + edge] > 1;
}

/// The number of the point where an edge of what is left ends.
std::size_t Simplifier::end_of_line(std::size_t path, std::size_t edge) const noexcept {
    const Reduction& of = paths_[path];
    return edge + 1 < of.left ? left_[of.first_left + edge + 1] : of.last - of.begin;
}

void Simplifier::object_to(std::size_t path, std::size_t edge) noexcept {
    in_conflict_[paths_[path].begin + left_[paths_[path].first_left + edge]] = 1;
}

void Simplifier::compare(const EdgePath& a, std::size_t i, const EdgePath& b, std::size_t j) {
    const bool a_is_line = is_line(a.contour, i);
    const bool b_is_line = is_line(b.contour, j);
    if (!a_is_line && !b_is_line) {
        return;
    }
    const bool into_b = a.contour == b.contour && (i + 1 == j || (a.closed && j == 0 && i + 1 == a.edges()));
    const bool into_a = a.contour == b.contour && (j + 1 == i || (a.closed && i == 0 && j + 1 == a.edges()));
    const bool in_conflict = into_b   ? folds_back(a[i], a[i + 1], b[j + 1])
                             : into_a ? folds_back(b[j], b[j + 1], a[i + 1])
                                      : have_common_point(a[i], a[i + 1], b[j], b[j + 1]);
    if (in_conflict && a_is_line) {
        object_to(a.contour, i);
    }
    if (in_conflict && b_is_line) {
        object_to(b.contour, j);
    }
}

/// Ends early where steps_ comes to more than `most`.
void Simplifier::find_jumps(std::size_t path, std::uint64_t most) {
    const Reduction& of = paths_[path];
    for (std::size_t edge = 0; edge + (of.closed ? 0 : 1) < of.left && steps_ <= most; ++edge) {
        if (!is_line(path, edge)) {
            continue;
        }
        const std::size_t first = of.begin + left_[of.first_left + edge];
        const std::size_t last = of.begin + end_of_line(path, edge);
        if (in_conflict_[first] == 0) {
            const std::uint64_t before = steps_;
            list_beside(path, first, last, most);
            in_conflict_[first] = !beside_.empty() && jumps_over_any(first, last, most) ? 1 : 0;
            worker_.spend(chain_work * (steps_ - before));
        }
    }
}

/// Lists the starts of other paths that may lie between a chain and its line: no ends of the chain, and no farther from the
/// line than the chain, which is the tolerance at most.
void Simplifier::list_beside(std::size_t path, std::size_t first, std::size_t last, std::uint64_t most) {
    const Point a = points_[first];
    const Point b = points_[last];
    const Vector2 line = between(a, b);
    beside_.clear();
    worker_.spend(last - first);
    starts_tree_.find_in(FlatBox::around(std::span(points_).subspan(first, last + 1 - first)),
                         [&](Point start, std::uint32_t other) {
                             ++steps_;
                             if (other != path && start != a && start != b &&
                                 is_beside(distance_by_length(line, between(a, start)), line, tolerance_)) {
                                 beside_.push_back({start, 0});
                             }
                             return steps_ <= most;
                         });
}

/// True if one of beside_ lies on the chain or within the ring of it and the line back. The rays that edges are counted on
/// lead across the line: a chain that follows the line passes each of them a few times, however many its edges are.
bool Simplifier::jumps_over_any(std::size_t first, std::size_t last, std::uint64_t most) {
    const Vector2 line = between(points_[first], points_[last]);
    const auto along = [wide = std::abs(line.x) > std::abs(line.y)](Point p) { return wide ? p.x : p.y; };
    sort_briefly(beside_.begin(), beside_.end(),
                 [&](const Beside& a, const Beside& b) { return along(a.start) < along(b.start); });
    worker_.spend(chain_work * (last - first));
    for (std::size_t i = first; i <= last && steps_ <= most; ++i) {
        const Point from = points_[i];
        const Point to = points_[i < last ? i + 1 : first];
        const auto [low, high] = std::minmax({along(from), along(to)});
        auto at = std::lower_bound(beside_.begin(), beside_.end(), low,
                                   [&](const Beside& beside, std::int32_t least) { return along(beside.start) < least; });
        for (; at != beside_.end() && along(at->start) <= high; ++at) {
            ++steps_;
            if (lies_on(at->start, from, to)) {
                return true;
            }
            const int direction = (along(from) <= along(at->start) ? 1 : 0) - (along(to) <= along(at->start) ? 1 : 0);
            at->winding += direction * side_of(from, to, at->start) > 0 ? direction : 0;
        }
    }
    return std::any_of(beside_.begin(), beside_.end(), [](const Beside& beside) { return beside.winding != 0; });
}

/// Objects to all lines where fewer than three points would be left, or the area would change its sign.
void Simplifier::keep_orientation(std::size_t path, const NestItem& item) {
    const Reduction& of = paths_[path];
    const Point* const points = left_points_.data() + of.first_left;
    worker_.spend(of.left);
    if (!of.closed ||
        (of.left >= 3 && sign_of(examine_ring(points, of.left).twice_area) == sign_of(to_int128(item.twice_area)))) {
        return;
    }
    for (std::size_t edge = 0; edge < of.left; ++edge) {
        if (is_line(path, edge)) {
            object_to(path, edge);
        }
    }
}

/// True if there was something to give back.
bool Simplifier::give_back(int round) {
    bool any = false;
    for (std::size_t p = 0; p < paths_.size(); ++p) {
        Reduction& path = paths_[p];
        for (std::size_t edge = 0; edge < path.left; ++edge) {
            const std::size_t first = path.begin + left_[path.first_left + edge];
            if (in_conflict_[first] != 0) {
                in_conflict_[first] = 0;
                split(first, path.begin + end_of_line(p, edge), round, round > rounds_by_distance);
                path.has_changed = any = true;
            }
        }
    }
    return any;
}

/// Into 2^times parts and more: a part may lie further from its points than the whole did.
void Simplifier::split(std::size_t first, std::size_t last, int times, bool by_halves) {
    if (last - first < 2 || times == 0) {
        reduce_chain(first, last);
        return;
    }
    worker_.spend(chain_work * (last - first));
    const std::size_t at =
        by_halves ? first + (last - first) / 2 : measure_chain(points_.data(), first, last, tolerance_).furthest;
    is_left_[at] = 1;
    split(first, at, times - 1, by_halves);
    split(at, last, times - 1, by_halves);
}

void Simplifier::write(std::span<NestItem> items) {
    left_origins_.resize(items.empty() || items[0].origins == nullptr ? 0 : left_.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        const Reduction& path = paths_[i];
        NestItem& item = items[i];
        if (path.left == path.count()) {
            continue;
        }
        if (item.origins != nullptr) {
            write_origins(i, item);
            item.origins = left_origins_.data() + path.first_left;
        }
        item.points = left_points_.data() + path.first_left;
        item.count = static_cast<std::uint32_t>(path.left);
        item.start = 0;
        if (item.closed) {
            const RingFacts facts = examine_ring(item.points, item.count);
            item.twice_area = to_integer128(facts.twice_area);
            item.box = facts.box;
        }
        worker_.spend(path.left);
    }
}

/// Lines come from no triangle, nor does the end of a polyline that a line leads to.
void Simplifier::write_origins(std::size_t path, const NestItem& item) noexcept {
    const Reduction& of = paths_[path];
    bool after_line = false;
    for (std::size_t edge = 0; edge < of.left; ++edge) {
        const bool is_end = !of.closed && edge + 1 == of.left;
        const bool from_none = is_end ? after_line : is_line(path, edge);
        left_origins_[of.first_left + edge] =
            from_none ? PointOrigin() : item.origin_from_start(left_[of.first_left + edge]);
        after_line = from_none;
    }
}

}  // namespace lamella
