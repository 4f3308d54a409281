// The targets that a slice is made for: a result in memory, a sink, the host's own arrays. What makes layers, a sweep or the
// projection of faces or the union of parts, does not know which.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/function_ref.hpp"
#include "base/parallel.hpp"
#include "lamella/result.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/placement.hpp"

namespace lamella {

/// Kept from call to call.
struct OutputScratch {
    explicit OutputScratch(const Memory* memory) : memory(memory), placement(memory) {}
    const Memory* memory;
    Placement placement;
    std::vector<std::unique_ptr<BandOutput>> outputs;  ///< of sinks
};

/// All that is known before layers are made.
struct OutputPlan {
    PlaneIndex layers;
    FunctionRef<Layer(PlaneIndex)> layer_at;  ///< without its contours; its segments when it has been made
    std::uint64_t segments;                   ///< of all layers: how many points there will be, but for a few
    std::uint64_t cutting;                    ///< layers that have segments
    std::span<const Band> bands;              ///< empty until they are cut
    const Parallel& parallel;
    OutputScratch& scratch;
    bool origins;                   ///< SliceOptions::origins
    SliceResult& result;            ///< unit, frame, plan and summary; arrays only where the slice is made for it
    std::size_t lead;               ///< how many bands may be begun beyond the first that is not done
    std::uint64_t first_index = 0;  ///< of the first layer, for sinks
};

/// The lead of bands that all threads sweep.
inline std::size_t usual_lead(const Parallel& parallel) noexcept {
    return 2 * static_cast<std::size_t>(parallel.threads());
}

/// The functions are called in their order.
class LayerTarget {
public:
    /// The number of layers is known, and of `info` what is known before anything is cut. Throws Refused where it is too
    /// much.
    virtual void admit_layers(std::uint64_t /*layers*/, const SliceInfo& /*info*/) const {}
    /// The same for the size of what a sweep makes, of which nothing is allocated yet.
    virtual void admit(const OutputPlan& plan, std::uint64_t /*memory_limit*/) const {
        admit_layers(plan.layers, plan.result.info);
    }
    /// How many segments a band should have at most.
    virtual std::uint64_t most_band_segments(int /*threads*/) const noexcept { return BandPlan::no_limit; }
    /// Where the bands go, all of which are then submitted there.
    virtual BandTarget& begin(const OutputPlan& plan) = 0;
    /// After the scratch of what made the bands has been released: completes result and summary.
    virtual void finish(const OutputPlan& plan) = 0;

protected:
    ~LayerTarget() = default;
};

/// A slice that is made for OutputPlan::result.
class ResultTarget final : public LayerTarget {
public:
    void admit(const OutputPlan& plan, std::uint64_t memory_limit) const override;
    BandTarget& begin(const OutputPlan& plan) override;
    void finish(const OutputPlan& plan) override;
};

/// Has the arrays of `result` take their memory from there. Those that take it from elsewhere are emptied.
void move_to(const Memory* memory, SliceResult& result);

/// The layer of a plane, without its contours.
inline Layer describe_layer(const PlaneSet& planes, PlaneIndex plane, std::uint64_t segments) {
    return {planes.bottom_mm(plane),     planes.height_mm(plane), planes.top_mm(plane), 0, 0, segments,
            PlaneHeight(planes.z(plane))};
}

/// Writes all layers, without their contours, to `layers`.
void fill_layers(const OutputPlan& plan, std::span<Layer> layers);

/// SliceInfo::layers, layer_of, first_layer and planned_layers; `list_heights`: the options have not chosen them.
void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info);

/// Adds what a part of a slice has read, swept and spent.
void add_work(const SliceInfo& part, SliceInfo& sum) noexcept;

}  // namespace lamella
