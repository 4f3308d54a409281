// From the links of a plane to its layer in the band's output.
//
//     ring_reader      points in walking order; start, box and area of each contour
//     repair           open polylines joined over gaps, where asked for
//     canonical_order  contours by start
//     nesting          parents and roles
//     layer_region     what a fill rule and other rules of regions make of the contours, then parents and roles
//     canonical_order  holes after their outers
//     append           the result's contours and points
#pragma once

#include <optional>
#include <span>

#include "base/parallel.hpp"
#include "base/worker.hpp"
#include "lamella/result.hpp"
#include "slicing/contours/link_graph.hpp"
#include "slicing/layer/canonical_order.hpp"
#include "slicing/layer/layer_region.hpp"
#include "slicing/layer/ring_reader.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/repair/polylines.hpp"
#include "slicing/result/band_output.hpp"

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

inline constexpr LayerRules plain_layers;

/// Time spent in nesting and with the fill rule; see StageTimes.
struct LayerTicks {
    std::uint64_t nesting = 0;
    std::uint64_t fill = 0;
};

/// Layer after layer; scratch is kept. One per thread.
class LayerBuilder {
public:
    explicit LayerBuilder(Worker& worker) noexcept : worker_(worker) {}

    // The layer's contours come from one of these. All throw std::bad_alloc.

    /// Those that `graph` holds; points[slot] is where the slot's edge pierces the plane, and origins[slot] where its
    /// segments come from, or null.
    void read(const LinkGraph& graph, const Point* points, const SlotOrigins* origins) {
        rings_.read(graph, points, origins, contours_.paths);
    }
    /// Closed ones whose points lie in walking order in `rings` already; see lamella::read_traced().
    void read_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                     const Parallel& parallel) {
        lamella::read_traced(rings, origins, walked, key_at, parallel, contours_.paths);
    }
    /// Those that are not walked but given, each with points: see given_path(). Where NestItem::reverse is set, the facets
    /// run the other way.
    void read_given(std::span<const Path> contours) {
        (given_ ? *given_ : given_.emplace(worker_)).list(contours, contours_.paths);
    }

    /// Appends the layer of the contours that were read to `out`. O(q log q) for q points. Throws std::bad_alloc.
    void build(BandOutput& out);
    /// Appends the contours of a region, as of `part`, without ending the layer; returns how many. The steps that follow the
    /// fill rule are taken.
    std::uint32_t append_region(const Fill& region, std::uint32_t part, BandOutput& out);

    /// Apply to layers built after this.
    const LayerRules* rules = &plain_layers;
    /// Time spent on layers built after this is added there, unless null.
    LayerTicks* ticks = nullptr;

private:
    void close_gaps(BandOutput& out);
    bool nest(FillRule rule);
    void append(BandOutput& out);
    template <class T>
    void copy_rotated(const T* from, std::size_t first, std::size_t count, T* to);

    Worker& worker_;
    LayerContours contours_{worker_};
    RingReader rings_{worker_};
    std::optional<GivenContours> given_;  // each made where it is first needed
    std::optional<PolylineRepair> repair_;
    std::optional<LayerRegion> region_;
};

}  // namespace lamella
