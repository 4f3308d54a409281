// The rules of regions on a layer's contours, stage by stage:
//
//     regions      what the closed contours bound by the fill rule, closed and offset, takes their place
//     rewrite      contours that were made, or lose points on lines, get points of their own
//     keep_some    the outermost ones, or the largest with its holes, where only they are wanted
//     simplify     points that a tolerance spares go
//     mark_near    contours that closing would change are marked
#pragma once

#include <cstdint>
#include <span>

#include "base/vector.hpp"
#include "lamella/options.hpp"
#include "slicing/layer/canonical_order.hpp"
#include "slicing/regions/regions.hpp"
#include "slicing/simplify/simplifier.hpp"

namespace lamella {

/// Layer after layer; scratch is kept. One per thread, as `layer` is.
class LayerRegion {
public:
    explicit LayerRegion(LayerContours& layer) noexcept : layer_(layer) {}

    /// Changes the contours of the layer, which are listed by start, and finds their parents and roles. Returns true where
    /// the fill rule let facets cancel each other. Points that were made stay until the next call. Throws std::bad_alloc.
    bool apply(const RegionRules& rules, FillRule fill, double grid_mm);
    /// The same for a layer of no contours but a region's, which must stay. The rules' fill rule is not looked at.
    void take(const Fill& region, const RegionRules& rules, double grid_mm);

private:
    void replace_closed(FillRule fill);
    RegionSteps steps() const noexcept {
        return {
            .close = rules_->closing_mm / grid_mm_, .offset = rules_->offset_mm / grid_mm_, .miter = rules_->miter_limit};
    }
    void take_paths(bool outermost);
    void mark_near();
    void rewrite_paths();
    void rewrite(Path& path, std::span<Point> points, PointOrigin* origins) const;
    bool is_rewritten(const Path& path) const noexcept;
    void nest_region();
    void keep_some(bool outermost, bool largest);
    void simplify();

    LayerContours& layer_;
    const Memory* memory_ = layer_.worker.memory();
    Regions regions_{layer_.worker};
    Simplifier simplifier_{layer_.worker};
    const RegionRules* rules_ = nullptr;  // of the layer
    double grid_mm_ = 0;
    Vector<Path> closed_{memory_};              // the closed ones of the layer, by start
    Vector<Path> kept_{memory_};                // of the layer's paths, where only some are wanted
    Vector<std::uint32_t> item_of_{memory_};    // of each of the layer's paths
    Vector<std::uint8_t> is_settled_{memory_};  // of each item: its parent is what it lies in
    Vector<Point> made_{memory_};               // points of paths that were made or lost some
    Vector<PointOrigin> made_origins_{memory_};
};

}  // namespace lamella
