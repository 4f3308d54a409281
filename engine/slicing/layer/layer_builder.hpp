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
#include "base/worker.hpp"
#include "lamella/result.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/layer/canonical_order.hpp"
#include "slicing/layer/ring_reader.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/regions.hpp"
#include "slicing/repair/polylines.hpp"
#include "slicing/result/band_output.hpp"
#include "slicing/simplify/simplifier.hpp"

namespace lamella {

/// Everything that is done to a plane's contours beyond walking them.
struct LayerRules {
    const RegionRules* region = nullptr;  ///< null: contours stay as they are
    double grid_mm = default_grid_mm;
    double stitch = 0;           ///< grid units
    double crossing_stitch = 0;  ///< grid units: longer joints cross no contour
    StitchDirection direction = StitchDirection::oriented;
    std::uint64_t first_layer = 0;  ///< of the plan's layers, which the rules count; see SliceOptions::layers
};

/// Layer after layer; scratch is kept. One per thread.
class LayerBuilder {
public:
    explicit LayerBuilder(Worker& worker) noexcept : worker_(worker) {}

    /// Appends the layer that `graph` holds to `out`; points[slot] is where the slot's edge pierces the plane, and
    /// origins[slot] where its segments come from, null where `out` takes no origins. O(q log q) for q points. Throws
    /// std::bad_alloc.
    void build(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, BandOutput& out);

    /// The same for closed contours whose points lie in walking order in `rings` already; see read_traced().
    void build_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                      const Parallel& parallel, BandOutput& out);

    /// The same for contours that are not walked but given, each with points: see given_path(). Where NestItem::reverse is
    /// set, the facets run the other way.
    void build_given(std::span<const Path> contours, BandOutput& out);

    /// Apply to layers built after this.
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
    void rewrite_paths();
    void rewrite(Path& path, std::span<Point> points, PointOrigin* origins) const;
    bool is_rewritten(const Path& path) const noexcept;
    void nest_region();
    void keep_some(bool outermost, bool largest);
    const Path& path_of(std::size_t item) const noexcept { return paths_[order_.path_of(item)]; }
    void append(BandOutput& out);
    template <class T>
    void copy_rotated(const T* from, std::size_t first, std::size_t count, T* to);

    Worker& worker_;
    RingReader rings_{worker_};
    PolylineRepair repair_{worker_};
    CanonicalOrder order_{worker_};
    Nester nester_{worker_};
    Regions regions_{worker_};
    Simplifier simplifier_{worker_};
    Vector<Path> paths_{worker_.memory()};      // of the plane; a fill rule replaces the closed ones
    Vector<NestItem> items_{worker_.memory()};  // of paths_, by start
    // For rules of regions:
    Vector<Path> closed_{worker_.memory()};              // the closed ones of paths_, by start
    Vector<Path> kept_{worker_.memory()};                // of paths_, where only some are wanted
    Vector<std::uint32_t> item_of_{worker_.memory()};    // of each of paths_
    Vector<std::uint8_t> is_settled_{worker_.memory()};  // of each item: its parent is what it lies in
    Vector<Point> made_{worker_.memory()};               // points of paths that were made or lost some
    Vector<PointOrigin> made_origins_{worker_.memory()};
    Vector<Point> given_{worker_.memory()};  // points of contours that were not walked
    Vector<PointOrigin> given_origins_{worker_.memory()};
    bool with_origins_ = false;  // of the layer
    bool cancels_ = false;       // as Fill::cancels(), of the layer
};

}  // namespace lamella
