#include "6_contours/layer_builder.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/clock.hpp"

namespace lamella {

namespace {

/// Room around each ring: the last point before it, the first behind it, and what a vector load may touch beyond.
constexpr std::size_t ring_front = 1;
constexpr std::size_t ring_padding = 4;

/// Whether the closed ring read from `a` on is smaller than read from `b` on.
bool rotation_before(const Point* ring, std::uint32_t count, std::uint32_t a, std::uint32_t b) {
    for (std::uint32_t i = 0; i < count; ++i) {
        const Point& from_a = ring[(a + i) % count];
        const Point& from_b = ring[(b + i) % count];
        if (from_a != from_b) {
            return from_a < from_b;
        }
    }
    return false;
}

/// Keeps one of equal consecutive points. Returns how many are left.
std::uint32_t drop_repeats(Point* points, std::uint32_t count, bool closed) {
    auto kept = static_cast<std::uint32_t>(std::unique(points, points + count) - points);
    while (closed && kept > 1 && points[kept - 1] == points[0]) {
        --kept;
    }
    return kept;
}

}  // namespace

Point* BandOutput::reserve_points(std::size_t count) {
    if (point_count + count > points.capacity()) {
        Array<Point> larger(points.resource());
        larger.resize_discarding(std::max(point_count + count, points.capacity() + points.capacity() / 2));
        std::copy_n(points.data(), point_count, larger.data());
        points = std::move(larger);
    }
    points.set_size(points.capacity());
    return points.data() + point_count;
}

LayerBuilder::LayerBuilder(std::pmr::memory_resource* memory)
    : kernels_(kernels_for_this_cpu()),
      nester_(memory),
      rings_(memory),
      items_(memory),
      start_keys_(memory),
      segments_(memory),
      by_start_(memory),
      placed_(memory),
      rank_(memory) {}

void LayerBuilder::build(const LinkGraph& graph, const Point* points, BandOutput& out) {
    gather(graph, points);
    const std::uint64_t before = timed ? ticks() : 0;
    nester_.nest(items_);
    nesting_ticks += timed ? ticks() - before : 0;
    sort_canonically();
    append(out);
}

/// Copies each contour's points in walking order, finds its facts and its start.
void LayerBuilder::gather(const LinkGraph& graph, const Point* points) {
    const std::span<const Slot> order = graph.order();
    const std::span<const WalkedContour> contours = graph.contours();
    const std::size_t room = order.size() + contours.size() * (ring_front + 1) + ring_padding;
    if (rings_.size() < room) {
        rings_.resize(room + room / 2);
    }
    items_.clear();
    start_keys_.clear();
    segments_.clear();
    Point* ring = rings_.data();
    for (const WalkedContour& walked : contours) {
        ring += ring_front;
        const Slot* slots = order.data() + walked.begin;
        for (std::uint32_t i = 0; i < walked.count; ++i) {
            ring[i] = points[slots[i]];
        }
        if (walked.closed) {
            examine_closed(graph, walked, ring);
        } else {
            examine_open(graph, walked, ring);
        }
        ring += walked.count + 1;
    }
}

void LayerBuilder::examine_closed(const LinkGraph& graph, const WalkedContour& walked, Point* ring) {
    std::uint32_t count = walked.count;
    ring[-1] = ring[count - 1];
    ring[count] = ring[0];
    const RingFacts facts = kernels_.examine(ring, count);
    const Int128 twice_area = kernels_.twice_area(ring, count, facts);
    std::uint32_t start = pick_start(graph, walked, ring, facts);
    start_keys_.push_back(graph.key(graph.order()[walked.begin + start]));
    if (facts.has_repeats) {
        std::rotate(ring, ring + start, ring + count);
        start = 0;
        count = drop_repeats(ring, count, true);
    }
    NestItem& item = items_.emplace_back();
    item.points = ring;
    item.count = count;
    item.start = start;
    item.twice_area = to_wide(twice_area);
    item.box_min = facts.box_min;
    item.box_max = facts.box_max;
    item.closed = true;
    item.flags = walked.mixed ? sense_mixed : 0;
    segments_.push_back(walked.count);
}

void LayerBuilder::examine_open(const LinkGraph& graph, const WalkedContour& walked, Point* ring) {
    start_keys_.push_back(graph.key(graph.order()[walked.begin]));
    NestItem& item = items_.emplace_back();
    item.points = ring;
    item.count = drop_repeats(ring, walked.count, false);
    item.flags = walked.mixed ? sense_mixed : 0;
    segments_.push_back(walked.count - 1);
}

/// The smallest (x, y, edge key); where a contour passes through one edge twice, the smaller of the two rotations.
std::uint32_t LayerBuilder::pick_start(const LinkGraph& graph, const WalkedContour& walked, const Point* ring,
                                       const RingFacts& facts) const {
    const std::uint32_t count = walked.count;
    const auto key_at = [&](std::uint32_t i) -> const EndKey& { return graph.key(graph.order()[walked.begin + i]); };
    auto best = static_cast<std::uint32_t>(kernels_.find_x(ring, 0, count, facts.box_min.x));
    for (std::size_t i = kernels_.find_x(ring, best + 1, count, facts.box_min.x); i < count;
         i = kernels_.find_x(ring, i + 1, count, facts.box_min.x)) {
        const auto other = static_cast<std::uint32_t>(i);
        if (ring[other].y != ring[best].y) {
            best = ring[other].y < ring[best].y ? other : best;
        } else if (key_at(other) != key_at(best)) {
            best = key_at(other) < key_at(best) ? other : best;
        } else if (rotation_before(ring, count, other, best)) {
            best = other;
        }
    }
    return best;
}

/// By start; what two contours that start on the same edge differ in, if in anything, decides between them.
bool LayerBuilder::starts_before(std::uint32_t a, std::uint32_t b) const {
    const NestItem& item_a = items_[a];
    const NestItem& item_b = items_[b];
    const Point& start_a = item_a.points[item_a.start];
    const Point& start_b = item_b.points[item_b.start];
    if (start_a != start_b) {
        return start_a < start_b;
    }
    if (start_keys_[a] != start_keys_[b]) {
        return start_keys_[a] < start_keys_[b];
    }
    if (item_a.role != item_b.role || item_a.count != item_b.count) {
        return item_a.role != item_b.role ? item_a.role < item_b.role : item_a.count < item_b.count;
    }
    for (std::uint32_t i = 0; i < item_a.count; ++i) {
        const Point& point_a = item_a.points[(item_a.start + i) % item_a.count];
        const Point& point_b = item_b.points[(item_b.start + i) % item_b.count];
        if (point_a != point_b) {
            return point_a < point_b;
        }
    }
    return segments_[a] < segments_[b];
}

/// placed_ becomes the canonical order: by start, each outer followed by its holes. A hole's leader is the nearest outer
/// around it; it starts before the hole, since it lies around it.
void LayerBuilder::sort_canonically() {
    const auto count = static_cast<std::uint32_t>(items_.size());
    by_start_.resize(count);
    rank_.resize(count);
    placed_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        by_start_[i] = i;
    }
    std::sort(by_start_.begin(), by_start_.end(), [this](std::uint32_t a, std::uint32_t b) { return starts_before(a, b); });
    for (std::uint32_t r = 0; r < count; ++r) {
        rank_[by_start_[r]] = r;
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t leader = i;
        while (items_[leader].role == Role::hole) {
            assert(items_[leader].parent >= 0 && "a hole lies in something");
            leader = static_cast<std::uint32_t>(items_[leader].parent);
        }
        placed_[i] = std::uint64_t{rank_[leader]} << 32 | rank_[i];
    }
    std::sort(placed_.begin(), placed_.end());
}

void LayerBuilder::append(BandOutput& out) {
    const std::size_t base = out.contours.size();
    // rank_ turns from "place by start" into "place in the layer".
    for (std::uint32_t place = 0; place < placed_.size(); ++place) {
        rank_[by_start_[placed_[place] & 0xFFFFFFFFU]] = place;
    }
    for (const std::uint64_t placed : placed_) {
        const std::uint32_t i = by_start_[placed & 0xFFFFFFFFU];
        const NestItem& item = items_[i];
        append_points(item, out.reserve_points(item.count));
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.twice_area = item.reverse ? to_wide(-from_wide(item.twice_area)) : item.twice_area;
        contour.parent =
            item.parent < 0 ? -1 : static_cast<std::int64_t>(base + rank_[static_cast<std::size_t>(item.parent)]);
        contour.point_count = item.count;
        contour.segments = segments_[i];
        contour.role = item.role;
        contour.sense = item.sense;
        contour.flags = item.flags;
        out.point_count += item.count;
    }
    out.layer_contours.push_back(static_cast<std::uint32_t>(placed_.size()));
}

/// From the start on, backwards if need be.
void LayerBuilder::append_points(const NestItem& item, Point* to) {
    if (item.reverse) {
        std::reverse_copy(item.points, item.points + item.start + 1, to);
        std::reverse_copy(item.points + item.start + 1, item.points + item.count, to + item.start + 1);
    } else {
        std::rotate_copy(item.points, item.points + item.start, item.points + item.count, to);
    }
}

}  // namespace lamella
