// The sets of a call, seen together: one grid, one stack of planes, and what the answer lies in.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/overlay.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/grid/exact.hpp"

namespace lamella {

class LayerSets {
public:
    /// `sets` must stay. Throws Refused, which names the set, where they do not go together.
    explicit LayerSets(std::span<const LayerSet> sets);

    std::span<const LayerSet> all() const noexcept { return sets_; }
    double grid_mm() const noexcept { return grid_mm_; }
    /// The largest coordinate of a set's region.
    double farthest_mm() const noexcept { return farthest_mm_; }
    /// What is known of an answer before its layers. `moved_mm`: how far regions reach beyond the sets.
    SliceInfo begin_info(const RegionRules& after, double moved_mm) const;
    /// Layer n of the answer, without contours.
    Layer describe(PlaneIndex n) const;
    /// A few layers each.
    std::vector<Band> cut_tasks(std::uint64_t layers, const Parallel& parallel) const;

private:
    double check_set(const LayerSet& set);
    void check_planes(const SliceResult& own) const;
    FlatBox bounds_of(const Layers& layers) const;
    void widen_box(const Layers& layers, const FlatBox& points, double moved_mm);

    std::span<const LayerSet> sets_;
    double grid_mm_ = default_grid_mm;
    double farthest_mm_ = 0;
    const SliceResult* stack_ = nullptr;  // the first; null: there is none
    std::optional<Box> box_;              // of all sets' regions
};

}  // namespace lamella
