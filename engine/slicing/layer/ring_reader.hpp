// The points of a plane in walking order, and for each contour the facts that order and nesting need: its start, box and
// area.
//
//     graph.order()     s7 s2 s9 s4 | s1 s5 s3 | ...          slots, contour by contour
//     rings             p7 p2 p9 p4 | p1 p5 p3 | ...          points; a contour's start is its smallest
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "base/worker.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/contours/slot_table.hpp"
#include "slicing/nesting/nest.hpp"

namespace lamella {

/// NestItem::flags of a walked contour.
inline std::uint16_t flags_of(const WalkedContour& walked) noexcept {
    return walked.mixed ? orientation_mixed : 0;
}

/// One per thread; scratch is kept. Contours point into it until the next call.
class RingReader {
public:
    explicit RingReader(Worker& worker) noexcept : worker_(worker) {}

    /// The contours of `graph`, in walking order; points[slot] is where the slot's edge pierces the plane, origins[slot]
    /// where its segments come from, unless `origins` is null. O(q) for q points. Throws std::bad_alloc.
    void read(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, Vector<Path>& contours) {
        const std::size_t room = graph.order().size() + padded_count;
        if (rings_.size() < room) {
            grow_exactly(rings_, room + room / 32, worker_);
        }
        if (origins != nullptr) {
            grow_exactly(origins_, rings_.size(), worker_);
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

private:
    // Work as StopPace counts it.
    static constexpr std::size_t ring_work = 16;
    static constexpr std::size_t point_work = 4;

    Path read_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                     PointOrigin* origins) {
        const auto slots = graph.order().subspan(walked.begin, walked.count);
        const RingFacts facts = trace(points, slots, ring);
        Path contour = closed_path(
            ring, walked.count, facts, [&](std::uint32_t i) { return to_key(graph.edge(slots[i])); }, origins);
        contour.item.flags = flags_of(walked);
        return contour;
    }

    /// By the kernel, which nothing interrupts, unless the contour is so long that its points, read as the walk met them,
    /// take long.
    RingFacts trace(const Point* points, std::span<const Slot> slots, Point* ring) {
        constexpr std::size_t most_at_once = std::size_t{1} << 20;
        if (slots.size() <= most_at_once) {
            return kernels_.trace(points, slots.data(), slots.size(), ring);
        }
        worker_.in_stretches(0, slots.size(), point_work, [&](std::size_t begin, std::size_t end) {
            std::transform(slots.data() + begin, slots.data() + end, ring + begin,
                           [points](Slot slot) { return points[slot]; });
        });
        return examine_ring(ring, slots.size(), [this] { worker_.ask(); });
    }

    static Path read_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring,
                          PointOrigin* origins) {
        const auto slots = graph.order().subspan(walked.begin, walked.count);
        std::transform(slots.begin(), slots.end(), ring, [points](Slot slot) { return points[slot]; });
        Path contour = open_path({ring, walked.count}, origins);
        contour.start_key = to_key(graph.edge(slots[0]));
        contour.segments = walked.count - 1;
        contour.item.flags = flags_of(walked);
        return contour;
    }

    /// Where facets agree, a slot is left by its source port.
    static void read_origins(const LinkGraph& graph, const WalkedContour& walked, const SlotOrigins* by_slot,
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

    Worker& worker_;
    const Kernels& kernels_ = best_of(kernel_forms(), worker_.instructions());
    Vector<Point> rings_{worker_.memory()};          // the plane's points in walking order
    Vector<PointOrigin> origins_{worker_.memory()};  // of rings_
};

/// The same for closed contours whose points lie in walking order in `rings` already. key_at(i) is the edge that rings[i]
/// lies on; `origins` are those of `rings`, or null.
inline void read_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                        const Parallel& parallel, Vector<Path>& contours) {
    contours.resize(walked.size());
    parallel.run_ranges(walked.size(), 64, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t c = first; c < last; ++c) {
            const auto [begin, count, closed, mixed] = walked[c];
            const RingFacts facts = examine_ring(rings + begin, count, [&parallel] { parallel.stop_if_asked(); });
            contours[c] = closed_path(
                rings + begin, count, facts, [&key_at, from = begin](std::uint32_t i) { return key_at(from + i); },
                origins == nullptr ? nullptr : origins + begin);
            contours[c].item.flags = flags_of(walked[c]);
        }
    });
}

/// A caller's contours: see given_path(). One per thread; scratch is kept.
class GivenContours {
public:
    explicit GivenContours(Worker& worker) noexcept : worker_(worker) {}

    /// Copies their points and lists them. Where NestItem::reverse is set, the facets run the other way. Throws
    /// std::bad_alloc.
    void list(std::span<const Path> given, Vector<Path>& contours) {
        points_.clear();
        origins_.clear();
        for (const Path& path : given) {
            const NestItem& item = path.item;
            points_.insert(points_.end(), item.points, item.points + item.count);
            origins_.insert(origins_.end(), item.origins, item.origins + (item.origins != nullptr ? item.count : 0));
            worker_.spend(item.count);
        }
        contours.clear();
        std::span<Point> rest(points_);
        for (const Path& path : given) {
            const NestItem& item = path.item;
            const std::span<Point> points = rest.first(item.count);
            rest = rest.subspan(item.count);
            PointOrigin* const origins = origins_.empty() ? nullptr : origins_.data() + (points.data() - points_.data());
            if (item.reverse) {
                turn_round(points, origins, item.closed);
            }
            Path& contour = contours.emplace_back(item.closed ? closed_path(points, origins) : open_path(points, origins));
            contour.segments = path.segments;
            contour.item.flags = item.flags;
            contour.item.part = item.part;
        }
    }

private:
    Worker& worker_;
    Vector<Point> points_{worker_.memory()};
    Vector<PointOrigin> origins_{worker_.memory()};
};

}  // namespace lamella
