#include "slicing/nesting/path.hpp"

#include <algorithm>
#include <compare>
#include <tuple>

#include "base/numbers.hpp"
#include "slicing/grid/origins.hpp"

namespace lamella {

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
    if (const std::strong_ordering by_points = compare_points(a, b); std::is_neq(by_points)) {
        return std::is_lt(by_points);
    }
    return a.flags != b.flags || a.origins == nullptr ? a.flags < b.flags : comes_from_less(a, b);
}

}  // namespace lamella
