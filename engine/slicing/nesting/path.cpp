#include "slicing/nesting/path.hpp"

#include <algorithm>
#include <compare>

#include "base/numbers.hpp"

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

}  // namespace lamella
