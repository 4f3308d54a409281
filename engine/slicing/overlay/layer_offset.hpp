// One layer of offsets: the region of a set, or what lies around lines, moved step by step.
//
//     list     the set's region, or its lines
//     move     each step from the region that the one before it made
//     append   the regions of the steps that are kept, as a part each
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/worker.hpp"
#include "lamella/overlay.hpp"
#include "slicing/layer/layer_builder.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/offset/raw_offset.hpp"
#include "slicing/overlay/layer_sets.hpp"
#include "slicing/overlay/set_reader.hpp"
#include "slicing/regions/regions.hpp"
#include "slicing/result/band_output.hpp"

namespace lamella {

/// The steps of a call, in grid units.
class OffsetPlan {
public:
    struct Step {
        double distance;
        bool keep;
        ArcDirections arcs;
    };

    /// Throws Refused where a step or an option is out of range, and std::bad_alloc.
    OffsetPlan(std::span<const OffsetStep> steps, const OffsetOptions& options, const LayerSet& of, const LayerSets& sets,
               const Memory* memory);

    bool is_of_lines() const noexcept { return end_ != End::region; }
    std::span<const Step> steps() const noexcept { return steps_; }
    Corners corners_of(const Step& step) const noexcept { return {limit_of(step), join_ == Join::round, end_, &step.arcs}; }
    std::uint64_t kept() const noexcept { return kept_; }
    /// How far the answer reaches beyond the set.
    double moved_mm() const noexcept { return moved_mm_; }

private:
    void check(const OffsetOptions& options, const LayerSet& of) const;
    void add(const OffsetStep& step, const OffsetOptions& options, const LayerSets& sets, const Memory* memory);
    double limit_of(const Step& step) const noexcept;

    Join join_;
    End end_;
    double miter_limit_;
    double tolerance_;  // of arcs, grid units
    std::vector<Step> steps_;
    std::uint64_t kept_ = 0;
    double moved_mm_ = 0;
};

/// Layer after layer; scratch is kept. One per thread.
class LayerOffset {
public:
    explicit LayerOffset(Worker& worker) noexcept : worker_(worker) {}

    /// Appends layer `n` of the answer to `out`, and returns how many of its parts may have contours. `after` must stay.
    /// Throws std::bad_alloc, and Refused where a curve leaves the grid.
    std::uint32_t run(const LayerSet& of, const OffsetPlan& plan, const LayerRules& after, std::uint64_t n, BandOutput& out);

private:
    Worker& worker_;
    Nester nester_{worker_};
    SetReader reader_{worker_};
    Regions regions_{worker_};
    LayerBuilder layers_{worker_};
};

}  // namespace lamella
