#include "slicing/layer/canonical_order.hpp"

#include <cassert>
#include <numeric>

namespace lamella {

namespace {

constexpr std::size_t item_work = 8;  ///< as StopPace counts it

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

/// Decides between contours that start on the same edge.
bool holds_less(const Path& path_a, const Path& path_b) {
    const NestItem& a = path_a.item;
    const NestItem& b = path_b.item;
    if (a.closed != b.closed) {
        return a.closed;
    }
    if (a.count != b.count) {
        return a.count < b.count;
    }
    if (path_a.segments != path_b.segments) {
        return path_a.segments < path_b.segments;
    }
    for (std::uint32_t i = 0; i < a.count; ++i) {
        const Point& point_a = a.from_start(i);
        const Point& point_b = b.from_start(i);
        if (point_a != point_b) {
            return point_a < point_b;
        }
    }
    return a.flags != b.flags || a.origins == nullptr ? a.flags < b.flags : comes_from_less(a, b);
}

}  // namespace

void CanonicalOrder::sort_by_start(std::span<const Path> contours) {
    by_start_.clear();
    for (std::uint32_t i = 0; i < contours.size(); ++i) {
        const NestItem& item = contours[i].item;
        worker_.spend(item_work);
        by_start_.push_back({nesting::key_of(item.points[item.start]), i});
    }
    nesting::sort_keys(by_start_, spare_keys_, worker_);
    nesting::sort_equal_keys(by_start_, [contours](const nesting::SortKey& key_a, const nesting::SortKey& key_b) {
        const Path& a = contours[key_a.index];
        const Path& b = contours[key_b.index];
        return a.start_key != b.start_key ? a.start_key < b.start_key : holds_less(a, b);
    });
}

/// A hole's leader is the nearest outer around it, any other item its own. The outer starts before the hole, or at the same
/// point where they touch there. Groups are counted, then filled: leaders first, holes by start.
void CanonicalOrder::put_holes_after_outers(std::span<const NestItem> items) {
    const std::size_t count = items.size();
    group_size_.assign(count, 0);
    leader_of_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const NestItem& item = items[i];
        worker_.spend(item_work);
        assert((item.role != Role::hole || item.parent >= 0) && "a hole lies in something");
        const auto around = static_cast<std::uint32_t>(item.parent);
        assert(item.role != Role::hole || around < i || items[around].role == Role::outer);
        leader_of_[i] = item.role != Role::hole ? i : (around < i ? leader_of_[around] : around);
        ++group_size_[leader_of_[i]];
    }
    next_place_.resize(count);
    std::exclusive_scan(group_size_.begin(), group_size_.end(), next_place_.begin(), 0U);
    place_of_.resize(count);
    item_at_.resize(count);
    for (const bool holes : {false, true}) {
        worker_.spend(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            if ((items[i].role == Role::hole) == holes) {
                place_of_[i] = next_place_[leader_of_[i]]++;
                item_at_[place_of_[i]] = i;
            }
        }
    }
}

}  // namespace lamella
