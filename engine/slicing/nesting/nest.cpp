#include "slicing/nesting/nest.hpp"

#include <cassert>
#include <iterator>
#include <limits>
#include <tuple>

#include "base/sort.hpp"

namespace lamella {

namespace {

using nesting::SortKey;

/// From small to large. Equal only if all points are equal.
std::strong_ordering compare_size(const NestItem& a, const NestItem& b) noexcept {
    if (size_of(a) != size_of(b)) {
        return size_of(a) < size_of(b) ? std::strong_ordering::less : std::strong_ordering::greater;
    }
    if (const auto order = a.points[a.start] <=> b.points[b.start]; order != 0) {
        return order;
    }
    if (const auto order = a.box <=> b.box; order != 0) {
        return order;
    }
    return compare_points(a, b);
}

constexpr std::size_t item_work = 16;  ///< as StopPace counts it

/// Orders by area. Areas beyond 64 bits share the highest key.
constexpr std::uint64_t huge_key = std::numeric_limits<std::uint64_t>::max();
std::uint64_t area_key(const NestItem& item) noexcept {
    return static_cast<std::uint64_t>(std::min<Int128>(size_of(item), huge_key));
}

}  // namespace

Int128 size_of(const NestItem& item) noexcept {
    const Int128 area = to_int128(item.twice_area);
    return area < 0 ? -area : area;
}

std::strong_ordering compare_points(const NestItem& a, const NestItem& b) noexcept {
    if (a.count != b.count) {
        return a.count <=> b.count;
    }
    for (std::uint32_t i = 0, ia = a.start, ib = b.start; i < a.count; ++i) {
        if (const auto order = a.points[ia] <=> b.points[ib]; order != 0) {
            return order;
        }
        ia = ia + 1 == a.count ? 0 : ia + 1;
        ib = ib + 1 == b.count ? 0 : ib + 1;
    }
    return std::strong_ordering::equal;
}

void NestItem::reset() noexcept {
    parent = -1;
    reverse = false;
    orientation = static_cast<std::int8_t>(closed ? sign_of(to_int128(twice_area)) : 0);
    role = closed ? Role::flat : Role::open;
}

void Nester::nest(std::span<NestItem> items) {
    assert(items.size() <= std::size_t{std::numeric_limits<std::int32_t>::max()});
    collect(items);
    sort_by_start(items);
    if (rings_.size() > 1) {
        find_parents(items);
    }
    assign_roles(items);
}

/// Sets the outputs of items that take no part in nesting and lists the starts of the rest.
void Nester::collect(std::span<NestItem> items) {
    reserve_keys(items.size());
    by_start_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
        NestItem& item = items[i];
        worker_.spend(item_work);
        item.reset();
        if (item.orientation != 0) {
            assert(item.start < item.count && item.points[item.start].x == item.box.low.x);
            const Point start = item.points[item.start];
            by_start_.push_back({nesting::key_of(start), static_cast<std::uint32_t>(i)});
        }
    }
}

/// Sorting exchanges the arrays' memory, so all of them get room for the largest layer.
void Nester::reserve_keys(std::size_t count) {
    if (count <= by_start_.capacity()) {
        return;
    }
    for (auto* keys : {&by_start_, &by_size_, &spare_keys_}) {
        keys->clear();
        keys->reserve(count + count / 2);
    }
}

/// Rings in the order of starts, of equal starts the smaller first.
void Nester::sort_by_start(std::span<const NestItem> items) {
    nesting::sort_keys(by_start_, spare_keys_, worker_);
    nesting::sort_equal_keys(by_start_, [items](const SortKey& a, const SortKey& b) {
        const std::strong_ordering order = compare_size(items[a.index], items[b.index]);
        return order != 0 ? order < 0 : a.index < b.index;
    });
    rings_.clear();
    for (const SortKey& key : by_start_) {
        worker_.spend(1);
        rings_.emplace_back().item = key.index;
    }
}

/// Every ring becomes the parent of the starts inside it that have none yet: the smallest ring first.
void Nester::find_parents(std::span<const NestItem> items) {
    const auto start = [this](std::size_t ring) { return start_of(ring); };
    starts_.assign(rings_.size(), start);
    list_containers(items);
    if (in_tree_) {
        tree_.assign(rings_.size(), start);
    }
    sort_by_size(items);
    for (const SortKey& key : by_size_) {
        const NestItem& contour = items[rings_[key.index].item];
        const auto take = [this](std::uint32_t ring) { found_.push_back(ring); };
        found_.clear();
        if (in_tree_) {
            tree_.find_in(grown(contour.box, -1), [&](Point, std::uint32_t ring) {
                take(ring);
                return true;
            });
        } else {
            starts_.find(rings_[key.index].right, grown(contour.box, -1), take);
        }
        take_in(contour, key.index);
    }
}

/// The rings whose boxes hold a start: most hold none. Where boxes are so wide that a tree is faster, the rest untested.
void Nester::list_containers(std::span<const NestItem> items) {
    constexpr std::size_t steps_per_ring = 16;
    by_size_.clear();
    in_tree_ = false;
    std::size_t steps = 0;
    std::uint32_t right = 0;
    for (std::uint32_t ring = 0; ring < rings_.size(); ++ring) {
        const NestItem& contour = items[rings_[ring].item];
        bool may_hold = in_tree_;
        if (!in_tree_) {
            while (right < rings_.size() && start_of(right).x <= contour.box.low.x) {
                ++right;
            }
            rings_[ring].right = right;
            const std::size_t taken = starts_.find(right, grown(contour.box, -1), [&](std::uint32_t) { may_hold = true; });
            worker_.spend(taken);
            steps += taken;
            in_tree_ = steps > steps_per_ring * (rings_.size() / 4 + ring);
        }
        worker_.spend(item_work);
        if (may_hold) {
            by_size_.push_back({area_key(contour), ring});
        }
    }
}

/// By area; equal areas in the order of rings, which is by start, then box and points.
void Nester::sort_by_size(std::span<const NestItem> items) {
    nesting::sort_keys(by_size_, spare_keys_, worker_);
    const auto huge =
        std::partition_point(by_size_.begin(), by_size_.end(), [](const SortKey& key) { return key.key != huge_key; });
    sort_briefly(huge, by_size_.end(), [&](const SortKey& a, const SortKey& b) {
        const auto size = [&](const SortKey& key) { return size_of(items[rings_[key.index].item]); };
        return std::pair(size(a), a.index) < std::pair(size(b), b.index);
    });
}

/// Tests the starts found in the contour's box: those inside are its children.
void Nester::take_in(const NestItem& contour, std::uint32_t ring) {
    constexpr std::size_t many = 8;
    constexpr std::size_t points_per_step = 4;
    worker_.spend(item_work + found_.size() * (found_.size() < many ? contour.count / points_per_step : 1));
    if (found_.size() < many) {
        for (const std::uint32_t child : found_) {
            if (nesting::strictly_inside(add_edges_, contour.points, contour.count, start_of(child))) {
                adopt(ring, child);
            }
        }
        return;
    }
    many_inside_.clear();
    for (const std::uint32_t child : found_) {
        many_inside_.add(start_of(child), child);
    }
    found_.clear();
    many_inside_.test(contour.points, contour.count, found_);
    for (const std::uint32_t child : found_) {
        adopt(ring, child);
    }
}

void Nester::adopt(std::uint32_t ring, std::uint32_t child) {
    rings_[child].parent = static_cast<std::int32_t>(ring);
    if (in_tree_) {
        tree_.take_off(child);
    } else {
        starts_.take_off(child);
    }
}

/// The facets' orientation decides the role unless a winding number, here or outside, is negative. Then the number of
/// enclosing contours does.
void Nester::assign_roles(std::span<NestItem> items) {
    for (nesting::Ring& ring : rings_) {
        NestItem& item = items[ring.item];
        worker_.spend(item_work);
        ring.winding = item.orientation > 0 ? 1 : -1;
        if (ring.parent >= 0) {
            const nesting::Ring& around = rings_[static_cast<std::size_t>(ring.parent)];
            item.parent = static_cast<std::int32_t>(around.item);
            ring.winding += around.winding;
            ring.depth = around.depth + 1;
            ring.overruled = around.overruled;
        }
        ring.overruled |= ring.winding < 0;
        const bool outer = ring.overruled ? ring.depth % 2 == 0 : item.orientation > 0;
        item.role = outer ? Role::outer : Role::hole;
        item.reverse = outer != (item.orientation > 0);
        if (ring.overruled) {
            item.flags = static_cast<std::uint16_t>(item.flags | orientation_overruled);
        }
    }
}

namespace {

NestItem closed_item(const Point* ring, std::uint32_t count, const RingFacts& facts, const PointOrigin* origins) noexcept {
    return {.points = ring,
            .origins = origins,
            .count = count,
            .start = static_cast<std::uint32_t>(facts.smallest),
            .twice_area = to_integer128(facts.twice_area),
            .box = facts.box,
            .closed = true};
}

/// True if the closed ring read from `a` on is smaller than read from `b` on.
bool rotation_before(const Point* ring, const PointOrigin* origins, std::uint32_t count, std::uint32_t a, std::uint32_t b) {
    const auto compare = [=](const auto* elements) {
        for (std::uint32_t i = 0; i < count; ++i) {
            if (const auto order = elements[(a + i) % count] <=> elements[(b + i) % count]; order != 0) {
                return order;
            }
        }
        return std::strong_ordering::equal;
    };
    const std::strong_ordering by_points = compare(ring);
    return by_points == 0 && origins != nullptr ? compare(origins) < 0 : by_points < 0;
}

/// The last of equal consecutive points begins an edge that has a length.
void keep_last_origins(const Point* points, PointOrigin* origins, std::uint32_t count) {
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        kept += i == 0 || points[i] != points[i - 1] ? 1 : 0;
        origins[kept - 1] = origins[i];
    }
}

/// Keeps one of equal consecutive points. Returns how many are left.
std::uint32_t drop_repeats(Point* points, PointOrigin* origins, std::uint32_t count, bool closed) {
    if (origins != nullptr) {
        keep_last_origins(points, origins, count);
    }
    auto kept = static_cast<std::uint32_t>(std::unique(points, points + count) - points);
    while (closed && kept > 1 && points[kept - 1] == points[0]) {
        --kept;
    }
    return kept;
}

std::uint32_t pick_start(const Point* ring, const PointOrigin* origins, std::uint32_t count, const RingFacts& facts,
                         KeyAt key_at) {
    auto best = static_cast<std::uint32_t>(facts.smallest);
    for (std::uint32_t other = best + 1; facts.many_smallest && other < count; ++other) {
        if (ring[other] != ring[facts.smallest]) {
            continue;
        }
        if (key_at(other) != key_at(best)) {
            best = key_at(other) < key_at(best) ? other : best;
        } else if (rotation_before(ring, origins, count, other, best)) {
            best = other;
        }
    }
    return best;
}

}  // namespace

NestItem closed_item(std::span<const Point> points, const PointOrigin* origins, std::uint32_t part) noexcept {
    NestItem item = closed_item(points.data(), static_cast<std::uint32_t>(points.size()),
                                examine_ring(points.data(), points.size()), origins);
    item.part = part;
    return item;
}

Path closed_path(Point* ring, std::uint32_t count, const RingFacts& facts, KeyAt key_at, PointOrigin* origins) {
    Path path;
    NestItem& item = path.item;
    item = closed_item(ring, count, facts, origins);
    item.start = pick_start(ring, origins, count, facts, key_at);
    path.start_key = key_at(item.start);
    path.segments = count;
    if (facts.has_repeats) {
        std::rotate(ring, ring + item.start, ring + count);
        if (origins != nullptr) {
            std::rotate(origins, origins + item.start, origins + count);
        }
        item.start = 0;
        item.count = drop_repeats(ring, origins, count, true);
    }
    return path;
}

Path closed_path(std::span<Point> ring, PointOrigin* origins) {
    return closed_path(
        ring.data(), static_cast<std::uint32_t>(ring.size()), examine_ring(ring.data(), ring.size()),
        [](std::uint32_t) { return EndKey{}; }, origins);
}

Path open_path(std::span<Point> points, PointOrigin* origins) {
    Path path;
    path.item.points = points.data();
    path.item.origins = origins;
    path.item.count = drop_repeats(points.data(), origins, static_cast<std::uint32_t>(points.size()), false);
    return path;
}

void turn_round(std::span<Point> points, PointOrigin* origins, bool closed) {
    std::reverse(points.begin(), points.end());
    if (origins == nullptr) {
        return;
    }
    PointOrigin* const last = origins + (points.size() - 1);
    std::reverse(origins, last);
    std::transform(origins, last, origins, turned);
    if (closed) {
        *last = turned(*last);
    } else if (points.size() > 1) {
        *last = end_of(last[-1]);
    }
}

namespace {

/// By part, triangle and edges of each contour edge. Contours of as many points.
bool comes_from_less(const NestItem& a, const NestItem& b) {
    for (std::uint32_t i = 0; i < a.count; ++i) {
        const PointOrigin& from_a = a.origins[(a.start + i) % a.count];
        const PointOrigin& from_b = b.origins[(b.start + i) % b.count];
        if (from_a != from_b) {
            return from_a.part != from_b.part ? from_a.part < from_b.part : from_a < from_b;
        }
    }
    return false;
}

}  // namespace

bool comes_before(const Path& path_a, const Path& path_b) {
    const NestItem& a = path_a.item;
    const NestItem& b = path_b.item;
    const auto key = [](const Path& path) {
        const NestItem& item = path.item;
        return std::tuple(item.points[item.start], path.start_key, !item.closed, item.count, path.segments);
    };
    if (key(path_a) != key(path_b)) {
        return key(path_a) < key(path_b);
    }
    if (const std::strong_ordering by_points = compare_points(a, b); by_points != 0) {
        return by_points < 0;
    }
    return a.flags != b.flags || a.origins == nullptr ? a.flags < b.flags : comes_from_less(a, b);
}

}  // namespace lamella
