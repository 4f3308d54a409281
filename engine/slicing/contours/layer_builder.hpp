// From the links of a plane to its layer in the band's output.
//
//     ring_reader      points in walking order; start, box and area of each contour
//     repair           open polylines joined over gaps, where asked for
//     canonical_order  contours by start
//     nesting          parents and roles (regions, where a fill rule is asked for: what is filled, then parents and roles)
//     simplify         points that a tolerance spares go, before nesting or after what a fill rule makes, where asked for
//     canonical_order  holes after their outers
//     append           the result's contours and points
#pragma once

#include <span>

#include "base/parallel.hpp"
#include "base/vector.hpp"
#include "lamella/result.hpp"
#include "slicing/contours/canonical_order.hpp"
#include "slicing/contours/layer_contour.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/contours/ring_reader.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/region_nesting.hpp"
#include "slicing/regions/regions.hpp"
#include "slicing/repair/polylines.hpp"
#include "slicing/result/band_output.hpp"
#include "slicing/simplify/simplifier.hpp"

namespace lamella {

/// What is done to a plane's contours beyond walking them.
struct LayerRules {
    const RegionRules* region = nullptr;  ///< null: contours stay as they are
    double unit_mm = default_unit_mm;
    double close_gaps = 0;     ///< grid units
    double crossing_gaps = 0;  ///< grid units: longer joints cross no contour
    GapSense gap_sense = GapSense::kept;
    std::uint64_t first_layer = 0;  ///< of the plan's layers, which the rules count; see SliceOptions::layers
};

/// A contour that is not walked.
struct GivenContour {
    std::span<const Point> points;
    std::span<const PointOrigin> origins{};  ///< of each point, or empty for all contours
    bool closed = true;
    bool turned = false;         ///< the facets run the other way
    std::uint32_t segments = 0;  ///< as Contour::segments
    std::uint16_t flags = 0;
    std::uint32_t part = 0;
};

/// Layer after layer; scratch is kept. One per thread.
class LayerBuilder {
public:
    explicit LayerBuilder(const Memory* memory);

    /// Appends the layer that `graph` holds to `out`; points[slot] is where the slot's edge pierces the plane, and
    /// origins[slot] where its segments come from, null where `out` takes no origins. O(q log q) for q points. Throws
    /// std::bad_alloc.
    void build(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, BandOutput& out);

    /// The same for closed contours whose points lie in walking order in `rings` already; see read_traced().
    void build_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                      const Parallel& parallel, BandOutput& out);

    /// The same for contours that are not walked but given, each with points.
    void build_given(std::span<const GivenContour> contours, BandOutput& out);

    /// From here on building a layer throws Stopped where the host wants the call to end.
    void follow(const StopCheck& host) noexcept;

    /// Of the layers to come.
    LayerRules rules;

    /// Time spent in nesting and with the fill rule since construction, for layers built with `timed`; see StageTimes.
    std::uint64_t nesting_ticks = 0;
    std::uint64_t fill_ticks = 0;
    bool timed = false;

private:
    void finish(BandOutput& out);
    void close_gaps(BandOutput& out);
    void sort_by_start();
    void nest(FillRule rule);
    void apply_rules(FillRule rule);
    void simplify();
    void replace_by_rings();
    std::size_t rewrite(const Ring& ring, std::span<Point> points, PointOrigin* origins) const;
    bool is_rewritten(const Ring& ring) const noexcept;
    void keep_some(bool outermost, bool largest);
    void append(BandOutput& out);
    void copy_points(const NestItem& item, Point* to);
    void copy_origins(const NestItem& item, PointOrigin* to);

    RingReader rings_;
    PolylineRepair repair_;
    CanonicalOrder order_;
    Nester nester_;
    Regions regions_;
    RegionNesting region_nesting_;
    Simplifier simplifier_;
    Vector<LayerContour> contours_;          // of the plane; a fill rule replaces the closed ones
    Vector<NestItem> items_;                 // of contours_, by start
    Vector<Polyline> polylines_;             // the open ones of contours_, for repair
    Vector<std::span<const Point>> around_;  // the closed ones
    // For rules of regions:
    Vector<LayerContour> walked_;      // contours_ before it was replaced
    Vector<NestItem> closed_;          // the closed ones of items_
    Vector<std::uint32_t> walked_of_;  // of each of closed_: its number in walked_
    Vector<std::int64_t> ring_of_;     // of each of items_: its number in the region, -1 for an open polyline
    Vector<Ring> region_;
    Vector<Ring> kept_;   // of the region, where only some are wanted
    Vector<Point> made_;  // points of rings that were made or lost some
    Vector<PointOrigin> made_origins_;
    Vector<Point> given_;  // points of contours that were not walked
    Vector<PointOrigin> given_origins_;
    bool with_origins_ = false;  // of the layer
    bool cancels_ = false;       // as Fill::cancels(), of the layer
    StopPace pace_;
};

}  // namespace lamella
