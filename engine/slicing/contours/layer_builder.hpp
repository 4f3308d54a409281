// Stage 6, from links to contours: the points of a plane in walking order, each contour from its canonical start, oriented
// and nested (stage 7), the layer in canonical order, appended to a band's output.
#pragma once

#include <span>
#include <vector>

#include "base/vector.hpp"
#include "lamella/array.hpp"
#include "lamella/result.hpp"
#include "slicing/contours/kernels.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/nesting/order.hpp"
#include "slicing/regions/fill.hpp"
#include "slicing/repair/gaps.hpp"

namespace lamella {

/// For the summary.
struct ContourCounts {
    std::uint64_t by_role[4] = {};  ///< index: Role
    std::uint64_t overruled = 0;

    void add(const Contour& contour) noexcept {
        ++by_role[static_cast<std::size_t>(contour.role)];
        overruled += (contour.flags & sense_overruled) != 0 ? 1 : 0;
    }
    void add(const ContourCounts& other) noexcept {
        for (std::size_t role = 0; role < 4; ++role) {
            by_role[role] += other.by_role[role];
        }
        overruled += other.overruled;
    }
    std::uint64_t of(Role role) const noexcept { return by_role[static_cast<std::size_t>(role)]; }
};

/// What a band of planes yields, kept by its thread until the bands below have been placed. Indices are relative to the
/// band.
struct BandOutput {
    explicit BandOutput(const Memory* memory)
        : buffer(memory), contours(memory), layer_contours(memory), closed_gaps(memory) {}

    Point* points =
        nullptr;  ///< where they go: the result's own array, where their place is known from the start, or `buffer`
    std::size_t point_count = 0;
    std::size_t capacity = 0;
    Array<Point> buffer;
    Vector<Contour> contours;
    ContourCounts counts;
    Vector<std::uint32_t> layer_contours;  ///< contours of each plane
    Vector<ClosedGap> closed_gaps;
    std::int64_t refused = -1;  ///< the first plane whose contours a fill rule could not be applied to

    /// Empty, with `room` to fill before `buffer` is turned to.
    void begin(std::span<Point> room) noexcept {
        points = room.data();
        capacity = room.size();
        point_count = 0;
        contours.clear();
        counts = {};
        layer_contours.clear();
        closed_gaps.clear();
        refused = -1;
    }
    bool in_buffer() const noexcept { return points == buffer.data(); }

    /// Makes room for `count` more points. Throws std::bad_alloc.
    Point* reserve_points(std::size_t count) {
        if (point_count + count > capacity) {
            move_to_buffer(count);
        }
        return points + point_count;
    }
    /// With room for `count` more. Throws std::bad_alloc.
    void move_to_buffer(std::size_t count);
};

/// What is done to a plane's contours beyond walking them.
struct LayerRules {
    FillRule fill = FillRule::contours;
    double close_gaps = 0;  ///< grid units
};

class LayerBuilder {
public:
    explicit LayerBuilder(const Memory* memory);

    /// Appends the layer that `graph` holds to `out`, or an empty one that out.refused names; points[slot] is where the
    /// slot's edge pierces the plane. O(q log q) for q points. Throws std::bad_alloc.
    void build(const LinkGraph& graph, const Point* points, BandOutput& out);

    /// The same for closed contours whose points already lie in walking order: each contour's from rings + begin on.
    /// key_at(i) is the edge that point i lies on.
    void build_traced(Point* rings, std::span<const WalkedContour> contours, FunctionRef<EndKey(std::uint32_t)> key_at,
                      const Parallel& parallel, BandOutput& out);

    /// Appends a layer without contours.
    static void skip(BandOutput& out) { out.layer_contours.push_back(0); }

    /// Of the layers to come.
    LayerRules rules;

    /// Time spent in nesting since construction, for layers built with `timed`; see StageTimes.
    std::uint64_t nesting_ticks = 0;
    bool timed = false;

private:
    /// A contour of the plane, as walked.
    struct Found {
        NestItem item;
        EndKey start_key;
        std::uint32_t segments;
        // Of a region that a rule fills; see RegionContour:
        std::int64_t cluster = -1;
        std::int64_t around = -1;  ///< an index of found_
        bool hole = false;
    };

    void gather(const LinkGraph& graph, const Point* points);
    void finish(BandOutput& out);
    static void refuse(BandOutput& out);
    Found describe(const WalkedContour& walked, Point* ring, const RingFacts& facts,
                   FunctionRef<EndKey(std::uint32_t)> key_at) const;
    Found examine_closed(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring) const;
    static Found examine_open(const LinkGraph& graph, const WalkedContour& walked, const Point* points, Point* ring);
    std::uint32_t pick_start(std::uint32_t count, const Point* ring, const RingFacts& facts,
                             FunctionRef<EndKey(std::uint32_t)> key_at) const;
    void close_gaps(BandOutput& out);
    void join(std::uint32_t polyline);
    bool apply_fill_rule();
    bool fill_region();
    Found describe_made(std::span<Point> ring) const;
    bool nest_region();
    void sort_by_start();
    void put_holes_behind_outers();
    void append(BandOutput& out) const;

    const Kernels& kernels_;
    Nester nester_;
    GapCloser gap_closer_;
    Fill fill_;
    Vector<Point> rings_;  // the plane's points in walking order, contour by contour
    Vector<Found> found_;
    Vector<Found> open_;         // of them, in canonical order, while gaps are closed
    Vector<PolylineEnds> ends_;  // of open_
    Vector<Point> joined_;       // points of polylines that were joined
    Vector<Found> walked_;       // found_, before a fill rule
    Vector<std::int32_t> around_clusters_;
    Vector<NestItem> closed_;                         // of items_, for a fill rule
    Vector<nesting::SortKey> by_start_, spare_keys_;  // of found_
    Vector<NestItem> items_;                          // in the order of by_start_
    Vector<std::uint32_t> placed_;                    // the items in canonical order
    Vector<std::uint32_t> place_of_, next_place_;     // of each item; of each leader
};

}  // namespace lamella
