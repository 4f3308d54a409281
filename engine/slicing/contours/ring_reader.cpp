#include "slicing/contours/ring_reader.hpp"

#include <algorithm>
#include <compare>

#include "slicing/grid/origins.hpp"

namespace lamella {

namespace {

// Work as StopPace counts it.
constexpr std::size_t ring_work = 16;
constexpr std::size_t point_work = 4;

/// Whether the closed ring read from `a` on is smaller than read from `b` on.
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

/// Of equal consecutive points the last begins an edge that has a length.
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

std::uint16_t flags_of(const WalkedContour& walked) noexcept {
    return walked.mixed ? orientation_mixed : 0;
}

}  // namespace

LayerContour closed_contour(Point* ring, std::uint32_t count, const RingFacts& facts, KeyAt key_at, PointOrigin* origins) {
    const std::uint32_t start = pick_start(ring, origins, count, facts, key_at);
    LayerContour contour;
    contour.start_key = key_at(start);
    contour.segments = count;
    NestItem& item = contour.item;
    item.points = ring;
    item.origins = origins;
    item.count = count;
    item.start = start;
    item.twice_area = to_integer128(facts.twice_area);
    item.box_min = facts.box_min;
    item.box_max = facts.box_max;
    item.closed = true;
    if (facts.has_repeats) {
        std::rotate(ring, ring + start, ring + count);
        if (origins != nullptr) {
            std::rotate(origins, origins + start, origins + count);
        }
        item.start = 0;
        item.count = drop_repeats(ring, origins, count, true);
    }
    return contour;
}

LayerContour closed_contour(std::span<Point> ring, PointOrigin* origins) {
    return closed_contour(
        ring.data(), static_cast<std::uint32_t>(ring.size()), examine_ring(ring.data(), ring.size()),
        [](std::uint32_t) { return EndKey{}; }, origins);
}

LayerContour open_contour(std::span<Point> points, PointOrigin* origins) {
    LayerContour contour;
    contour.item.points = points.data();
    contour.item.origins = origins;
    contour.item.count = drop_repeats(points.data(), origins, static_cast<std::uint32_t>(points.size()), false);
    return contour;
}

void RingReader::read(const LinkGraph& graph, const Point* points, const SlotOrigins* origins,
                      Vector<LayerContour>& contours) {
    const std::size_t room = graph.order().size() + padded_count;
    if (rings_.size() < room) {
        resize_exactly(rings_, room + room / 32, worker_);
    }
    if (origins != nullptr && origins_.size() < rings_.size()) {
        resize_exactly(origins_, rings_.size(), worker_);
    }
    contours.clear();
    reserve_more(contours, graph.contours().size());
    Point* ring = rings_.data();
    for (const WalkedContour& walked : graph.contours()) {
        PointOrigin* const own = origins == nullptr ? nullptr : origins_.data() + (ring - rings_.data());
        if (own != nullptr) {
            read_origins(graph, walked, origins, own);
        }
        contours.push_back(walked.closed ? read_closed(graph, walked, points, ring, own)
                                         : read_open(graph, walked, points, ring, own));
        ring += walked.count;
        worker_.spend(ring_work + walked.count);
    }
}

/// Where facets agree, a slot is left by its source port.
void RingReader::read_origins(const LinkGraph& graph, const WalkedContour& walked, const SlotOrigins* by_slot,
                              PointOrigin* origins) {
    const auto slots = graph.order().subspan(walked.begin, walked.count);
    const std::uint32_t segments = walked.closed ? walked.count : walked.count - 1;
    for (std::uint32_t i = 0; i < segments; ++i) {
        if (!walked.mixed) {
            origins[i] = by_slot[slots[i]].by_port[source_port];
            continue;
        }
        const PortRef port = graph.port_towards(slots[i], slots[i + 1 < walked.count ? i + 1 : 0]);
        const PointOrigin& origin = by_slot[slots[i]].by_port[port & 1];
        origins[i] = graph.runs_from(port) ? origin : turned(origin);
    }
    if (!walked.closed) {
        origins[segments] = end_of(origins[segments - 1]);
    }
}

LayerContour RingReader::read_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                                     PointOrigin* origins) {
    const auto slots = graph.order().subspan(walked.begin, walked.count);
    const RingFacts facts = trace(points, slots, ring);
    LayerContour contour = closed_contour(
        ring, walked.count, facts, [&](std::uint32_t i) { return to_key(graph.edge(slots[i])); }, origins);
    contour.item.flags = flags_of(walked);
    return contour;
}

/// By the kernel, which nothing interrupts, unless the contour is so long that its points, read as the walk met them, take
/// long.
RingFacts RingReader::trace(const Point* points, std::span<const Slot> slots, Point* ring) {
    constexpr std::size_t most_at_once = std::size_t{1} << 20;
    if (slots.size() <= most_at_once) {
        return kernels_.trace(points, slots.data(), slots.size(), ring);
    }
    worker_.in_stretches(0, slots.size(), point_work, [&](std::size_t begin, std::size_t end) {
        std::transform(slots.data() + begin, slots.data() + end, ring + begin, [points](Slot slot) { return points[slot]; });
    });
    return examine_ring(ring, slots.size(), [this] { worker_.ask(); });
}

LayerContour RingReader::read_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                                   PointOrigin* origins) {
    const auto slots = graph.order().subspan(walked.begin, walked.count);
    std::transform(slots.begin(), slots.end(), ring, [points](Slot slot) { return points[slot]; });
    LayerContour contour = open_contour({ring, walked.count}, origins);
    contour.start_key = to_key(graph.edge(slots[0]));
    contour.segments = walked.count - 1;
    contour.item.flags = flags_of(walked);
    return contour;
}

void read_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                 const Parallel& parallel, Vector<LayerContour>& contours) {
    contours.resize(walked.size());
    parallel.run_ranges(walked.size(), 64, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t c = first; c < last; ++c) {
            const auto [begin, count, closed, mixed] = walked[c];
            const RingFacts facts = examine_ring(rings + begin, count, [&parallel] { parallel.stop_if_asked(); });
            contours[c] = closed_contour(
                rings + begin, count, facts, [&key_at, from = begin](std::uint32_t i) { return key_at(from + i); },
                origins == nullptr ? nullptr : origins + begin);
            contours[c].item.flags = flags_of(walked[c]);
        }
    });
}

}  // namespace lamella
