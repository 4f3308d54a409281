#include "7_nesting/nest.hpp"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "7_nesting/inside.hpp"

namespace lamella {

namespace {

using nesting::Ring;

int sign_of(const Wide& area) noexcept {
    if (area.high < 0) {
        return -1;
    }
    return area.high > 0 || area.low > 0 ? 1 : 0;
}

std::pair<std::uint64_t, std::uint64_t> magnitude(const Wide& area) noexcept {
    const auto high = static_cast<std::uint64_t>(area.high);
    if (area.high >= 0) {
        return {high, area.low};
    }
    return {~high + (area.low == 0 ? 1 : 0), ~area.low + 1};
}

/// Compares the points of two contours from their starts on.
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

/// The order in which contours around a point are asked: from small to large, never by index.
bool smaller(const NestItem& a, const NestItem& b) noexcept {
    if (const auto order = magnitude(a.twice_area) <=> magnitude(b.twice_area); order != 0) {
        return order < 0;
    }
    if (const auto order = a.points[a.start] <=> b.points[b.start]; order != 0) {
        return order < 0;
    }
    if (const auto order = std::pair(a.box_min, a.box_max) <=> std::pair(b.box_min, b.box_max); order != 0) {
        return order < 0;
    }
    return compare_points(a, b) < 0;
}

bool box_strictly_contains(const Ring& ring, Point p) noexcept {
    return ring.box_min.x < p.x && p.x < ring.box_max.x && ring.box_min.y < p.y && p.y < ring.box_max.y;
}

}  // namespace

Nester::Nester(std::pmr::memory_resource* memory)
    : inside_(nesting::best_inside_test()), rings_(memory != nullptr ? memory : std::pmr::new_delete_resource()) {}

void Nester::nest(std::span<NestItem> items) {
    assert(items.size() <= std::size_t{std::numeric_limits<std::int32_t>::max()});
    collect(items);
    find_parents(items);
    assign_roles(items);
}

/// Settles what takes no part in nesting and lists the rest by start.
void Nester::collect(std::span<NestItem> items) {
    rings_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
        NestItem& item = items[i];
        item.parent = -1;
        item.reverse = false;
        item.sense = static_cast<std::int8_t>(item.closed ? sign_of(item.twice_area) : 0);
        item.role = item.closed ? Role::flat : Role::open;
        if (item.sense != 0) {
            assert(item.start < item.count && item.points[item.start].x == item.box_min.x);
            Ring ring;
            ring.start = item.points[item.start];
            ring.box_min = item.box_min;
            ring.box_max = item.box_max;
            ring.item = static_cast<std::uint32_t>(i);
            rings_.push_back(ring);
        }
    }
    std::sort(rings_.begin(), rings_.end(),
              [](const Ring& a, const Ring& b) { return a.start != b.start ? a.start < b.start : a.item < b.item; });
}

void Nester::find_parents(std::span<const NestItem> items) {
    for (std::size_t child = 1; child < rings_.size(); ++child) {
        const Point query = rings_[child].start;
        const NestItem* best = nullptr;
        for (std::size_t around = child; around-- > 0;) {
            const NestItem& item = items[rings_[around].item];
            if (box_strictly_contains(rings_[around], query) && (best == nullptr || !smaller(*best, item)) &&
                inside_(item.points, item.count, query)) {
                best = &item;
                rings_[child].parent = static_cast<std::int32_t>(around);
            }
        }
    }
}

/// The facets' sense stands as long as no winding number from the outside in is negative; below one that is, the number of
/// contours around decides.
void Nester::assign_roles(std::span<NestItem> items) {
    for (Ring& ring : rings_) {
        NestItem& item = items[ring.item];
        ring.winding = item.sense;
        if (ring.parent >= 0) {
            const Ring& around = rings_[static_cast<std::size_t>(ring.parent)];
            item.parent = static_cast<std::int32_t>(around.item);
            ring.winding += around.winding;
            ring.depth = around.depth + 1;
            ring.overruled = around.overruled;
        }
        ring.overruled |= ring.winding < 0;
        const bool outer = ring.overruled ? ring.depth % 2 == 0 : item.sense > 0;
        item.role = outer ? Role::outer : Role::hole;
        item.reverse = outer != (item.sense > 0);
        if (ring.overruled) {
            item.flags = static_cast<std::uint16_t>(item.flags | sense_overruled);
        }
    }
}

}  // namespace lamella
