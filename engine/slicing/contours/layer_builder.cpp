#include "slicing/contours/layer_builder.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "base/clock.hpp"
#include "lamella/memory.hpp"

namespace lamella {

namespace {

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

/// Decides between contours that start on the same edge.
bool holds_less(const NestItem& a, std::uint32_t segments_a, const NestItem& b, std::uint32_t segments_b) {
    if (a.closed != b.closed || a.count != b.count || segments_a != segments_b) {
        return a.closed != b.closed ? a.closed : (a.count != b.count ? a.count < b.count : segments_a < segments_b);
    }
    for (std::uint32_t i = 0; i < a.count; ++i) {
        const Point& point_a = a.from_start(i);
        const Point& point_b = b.from_start(i);
        if (point_a != point_b) {
            return point_a < point_b;
        }
    }
    return a.flags < b.flags;
}

/// From the start on, backwards if need be.
void append_points(const NestItem& item, Point* to) {
    if (item.reverse) {
        std::reverse_copy(item.points, item.points + item.start + 1, to);
        std::reverse_copy(item.points + item.start + 1, item.points + item.count, to + item.start + 1);
    } else {
        std::rotate_copy(item.points, item.points + item.start, item.points + item.count, to);
    }
}

}  // namespace

void BandOutput::move_to_buffer(std::size_t count) {
    if (buffer.capacity() < point_count + count) {
        Array<Point> larger(buffer.memory());
        larger.resize_discarding(std::max(point_count + count, buffer.capacity() + buffer.capacity() / 2));
        std::copy_n(points, point_count, larger.data());
        buffer = std::move(larger);
    } else {
        std::copy_n(points, point_count, buffer.data());
    }
    points = buffer.data();
    capacity = buffer.capacity();
}

LayerBuilder::LayerBuilder(const Memory* memory)
    : kernels_(best_of(kernel_forms())),
      nester_(memory),
      gap_closer_(memory),
      fill_(memory),
      rings_(memory),
      found_(memory),
      open_(memory),
      ends_(memory),
      joined_(memory),
      walked_(memory),
      around_clusters_(memory),
      closed_(memory),
      by_start_(memory),
      spare_keys_(memory),
      items_(memory),
      placed_(memory),
      place_of_(memory),
      next_place_(memory) {}

void LayerBuilder::build(const LinkGraph& graph, const Point* points, BandOutput& out) {
    gather(graph, points);
    finish(out);
}

void LayerBuilder::build_traced(Point* rings, std::span<const WalkedContour> contours,
                                FunctionRef<EndKey(std::uint32_t)> key_at, const Parallel& parallel, BandOutput& out) {
    found_.resize(contours.size());
    parallel.run_ranges(contours.size(), 64, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t c = begin; c < end; ++c) {
            const WalkedContour& walked = contours[c];
            Point* ring = rings + walked.begin;
            found_[c] = describe(walked, ring, examine_ring(ring, walked.count),
                                 [&](std::uint32_t i) { return key_at(walked.begin + i); });
        }
    });
    finish(out);
}

void LayerBuilder::finish(BandOutput& out) {
    if (out.refused >= 0) {
        skip(out);
        return;
    }
    if (rules.close_gaps > 0) {
        close_gaps(out);
    }
    sort_by_start();
    const std::uint64_t before = timed ? ticks() : 0;
    if (rules.fill == FillRule::contours) {
        nester_.nest(items_);
    } else if (!apply_fill_rule()) {
        refuse(out);
        return;
    }
    nesting_ticks += timed ? ticks() - before : 0;
    put_holes_behind_outers();
    append(out);
}

void LayerBuilder::refuse(BandOutput& out) {
    out.refused = static_cast<std::int64_t>(out.layer_contours.size());
    skip(out);
}

/// Copies each contour's points in walking order, finds its facts and its start.
void LayerBuilder::gather(const LinkGraph& graph, const Point* points) {
    const std::span<const Slot> order = graph.order();
    const std::span<const WalkedContour> contours = graph.contours();
    const std::size_t room = order.size() + padded_count;
    if (rings_.size() < room) {
        rings_.resize(room + room / 32);
    }
    found_.clear();
    Point* ring = rings_.data();
    for (const WalkedContour& walked : contours) {
        found_.push_back(walked.closed ? examine_closed(graph, walked, points, ring)
                                       : examine_open(graph, walked, points, ring));
        ring += walked.count;
    }
}

LayerBuilder::Found LayerBuilder::examine_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points,
                                                 Point* ring) const {
    const Slot* slots = graph.order().data() + walked.begin;
    const RingFacts facts = kernels_.trace(points, slots, walked.count, ring);
    return describe(walked, ring, facts, [&](std::uint32_t i) { return to_key(graph.edge(slots[i])); });
}

LayerBuilder::Found LayerBuilder::describe(const WalkedContour& walked, Point* ring, const RingFacts& facts,
                                           FunctionRef<EndKey(std::uint32_t)> key_at) const {
    const std::uint32_t count = walked.count;
    const std::uint32_t start = pick_start(count, ring, facts, key_at);
    Found found;
    found.start_key = key_at(start);
    found.segments = count;
    NestItem& item = found.item;
    item.points = ring;
    item.count = count;
    item.start = start;
    item.twice_area = to_integer128(facts.twice_area);
    item.box_min = facts.box_min;
    item.box_max = facts.box_max;
    item.closed = true;
    item.flags = walked.mixed ? sense_mixed : 0;
    if (facts.has_repeats) {
        std::rotate(ring, ring + start, ring + count);
        item.start = 0;
        item.count = drop_repeats(ring, count, true);
    }
    return found;
}

LayerBuilder::Found LayerBuilder::examine_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points,
                                               Point* ring) {
    std::transform(graph.order().begin() + walked.begin, graph.order().begin() + walked.begin + walked.count, ring,
                   [points](Slot slot) { return points[slot]; });
    Found found;
    found.start_key = to_key(graph.edge(graph.order()[walked.begin]));
    found.segments = walked.count - 1;
    found.item.points = ring;
    found.item.count = drop_repeats(ring, walked.count, false);
    found.item.flags = walked.mixed ? sense_mixed : 0;
    return found;
}

/// The smallest (x, y, edge key); where a contour passes through one edge twice, the smaller of the two rotations.
std::uint32_t LayerBuilder::pick_start(std::uint32_t count, const Point* ring, const RingFacts& facts,
                                       FunctionRef<EndKey(std::uint32_t)> key_at) const {
    auto best = static_cast<std::uint32_t>(facts.smallest);
    for (std::uint32_t other = best + 1; facts.many_smallest && other < count; ++other) {
        if (ring[other] != ring[facts.smallest]) {
            continue;
        }
        if (key_at(other) != key_at(best)) {
            best = key_at(other) < key_at(best) ? other : best;
        } else if (rotation_before(ring, count, other, best)) {
            best = other;
        }
    }
    return best;
}

// --- What is only done where it was asked for

/// Joins polylines over gaps. They are taken in canonical order, so that nothing depends on that of the walk.
void LayerBuilder::close_gaps(BandOutput& out) {
    const auto first_open =
        std::stable_partition(found_.begin(), found_.end(), [](const Found& f) { return f.item.closed; });
    open_.assign(first_open, found_.end());
    std::sort(open_.begin(), open_.end(), [](const Found& a, const Found& b) {
        const Point& start_a = a.item.points[0];
        const Point& start_b = b.item.points[0];
        if (start_a != start_b || a.start_key != b.start_key) {
            return start_a != start_b ? start_a < start_b : a.start_key < b.start_key;
        }
        return holds_less(a.item, a.segments, b.item, b.segments);
    });
    ends_.clear();
    std::size_t points = 0;
    for (const Found& open : open_) {
        ends_.push_back({open.item.points[0], open.item.points[open.item.count - 1]});
        points += open.item.count;
    }
    const std::span<const Gap> gaps = gap_closer_.close(ends_, rules.close_gaps);
    if (gaps.empty()) {
        return;
    }
    for (const Gap& gap : gaps) {
        out.closed_gaps.push_back({out.layer_contours.size(), ends_[gap.from].last, ends_[gap.to].first});
    }
    found_.erase(first_open, found_.end());
    joined_.clear();
    joined_.reserve(points);  // contours point into it
    for (const bool in_rings : {false, true}) {
        for (std::uint32_t p = 0; p < open_.size(); ++p) {
            if (open_[p].item.count > 0 && gap_closer_.follows(p) == in_rings) {
                join(p);
            }
        }
    }
}

/// The contour or polyline that begins with open_[polyline], whose count and that of all that follow it become 0.
void LayerBuilder::join(std::uint32_t polyline) {
    const std::size_t begin = joined_.size();
    Found found = open_[polyline];
    found.segments = 0;
    std::int64_t next = polyline;
    while (next >= 0 && open_[static_cast<std::size_t>(next)].item.count > 0) {
        Found& part = open_[static_cast<std::size_t>(next)];
        joined_.insert(joined_.end(), part.item.points, part.item.points + part.item.count);
        found.segments += part.segments;
        found.item.flags |= part.item.flags;
        part.item.count = 0;
        next = gap_closer_.next(static_cast<std::uint32_t>(next));
    }
    Point* const ring = joined_.data() + begin;
    const auto count = static_cast<std::uint32_t>(joined_.size() - begin);
    if (gap_closer_.follows(polyline)) {
        const std::uint32_t segments = found.segments;
        const std::uint16_t flags = found.item.flags | gap_closed;
        found = describe({0, count, true, false}, ring, examine_ring(ring, count), [](std::uint32_t) { return EndKey{}; });
        found.segments = segments;
        found.item.flags = flags;
    } else {
        if (gap_closer_.next(polyline) >= 0) {
            found.item.flags |= gap_closed;
        }
        found.item.points = ring;
        found.item.count = drop_repeats(ring, count, false);
    }
    found_.push_back(found);
}

// --- Canonical order

/// items_ becomes what was found, by start: (x, y, edge key). Contours that start on the same edge are told apart by what
/// they hold; those that hold the same are interchangeable.
void LayerBuilder::sort_by_start() {
    by_start_.clear();
    for (std::uint32_t i = 0; i < found_.size(); ++i) {
        const NestItem& item = found_[i].item;
        by_start_.push_back({nesting::key_of(item.points[item.start]), i});
    }
    nesting::sort_keys(by_start_, spare_keys_);
    nesting::sort_equal_keys(by_start_, [this](const nesting::SortKey& key_a, const nesting::SortKey& key_b) {
        const Found& a = found_[key_a.index];
        const Found& b = found_[key_b.index];
        return a.start_key != b.start_key ? a.start_key < b.start_key : holds_less(a.item, a.segments, b.item, b.segments);
    });
    items_.clear();
    for (const nesting::SortKey& key : by_start_) {
        items_.push_back(found_[key.index].item);
    }
}

/// placed_ becomes the canonical order: by start, each outer followed by its holes. A hole's leader is the nearest outer
/// around it, which starts before the hole, or at the same point where they touch there. Items are counted by leader, then
/// placed, leaders first.
void LayerBuilder::put_holes_behind_outers() {
    const std::size_t count = items_.size();
    next_place_.assign(count, 0);
    placed_.resize(count);
    place_of_.resize(count);  // at first: the leader
    for (std::uint32_t i = 0; i < count; ++i) {
        const NestItem& item = items_[i];
        assert((item.role != Role::hole || item.parent >= 0) && "a hole lies in something");
        const auto around = static_cast<std::uint32_t>(item.parent);
        assert(item.role != Role::hole || around < i || items_[around].role == Role::outer);
        place_of_[i] = item.role != Role::hole ? i : (around < i ? place_of_[around] : around);
        ++next_place_[place_of_[i]];
    }
    std::exclusive_scan(next_place_.begin(), next_place_.end(), next_place_.begin(), 0U);
    for (const bool holes : {false, true}) {
        for (std::uint32_t i = 0; i < count; ++i) {
            if ((items_[i].role == Role::hole) == holes) {
                place_of_[i] = next_place_[place_of_[i]]++;
                placed_[place_of_[i]] = i;
            }
        }
    }
}

void LayerBuilder::append(BandOutput& out) const {
    const std::size_t base = out.contours.size();
    for (const std::uint32_t i : placed_) {
        const NestItem& item = items_[i];
        append_points(item, out.reserve_points(item.count));
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.twice_area = item.reverse ? to_integer128(-to_int128(item.twice_area)) : item.twice_area;
        contour.parent =
            item.parent < 0 ? -1 : static_cast<std::int64_t>(base + place_of_[static_cast<std::size_t>(item.parent)]);
        contour.point_count = item.count;
        contour.segments = found_[by_start_[i].index].segments;
        contour.role = item.role;
        contour.sense = item.sense;
        contour.flags = item.flags;
        out.counts.add(contour);
        out.point_count += item.count;
    }
    out.layer_contours.push_back(static_cast<std::uint32_t>(placed_.size()));
}

}  // namespace lamella
