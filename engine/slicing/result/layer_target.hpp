// The targets that a slice is made for: a result in memory, a sink, the host's own arrays. The stages before the sweep are
// the same.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/result.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/bucket.hpp"
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

/// All that is known when the sweep begins.
struct SweepInput {
    const PlaneSet& planes;
    const Buckets& buckets;
    std::span<const Band> bands;  ///< empty until they are cut
    const Parallel& parallel;
    OutputScratch& scratch;
    bool origins;                   ///< SliceOptions::origins
    SliceResult& result;            ///< unit, frame, plan and summary; arrays only where the slice is made for it
    std::uint64_t first_index = 0;  ///< of the first layer, for sinks

    /// How many bands may be begun beyond the first that is not done.
    std::size_t lead() const noexcept { return 2 * static_cast<std::size_t>(parallel.threads()); }
};

/// The functions are called in their order.
class LayerTarget {
public:
    /// The size is known, and nothing of that size is allocated yet: throws Refused where it is too large. The result holds
    /// unit, rules and box.
    virtual void admit(const SweepInput& input, std::uint64_t memory_limit) = 0;
    /// How many segments a band should have at most.
    virtual std::uint64_t most_band_segments(int /*threads*/) const noexcept { return BandPlan::no_limit; }
    /// Where the bands go, all of which are then submitted there.
    virtual BandTarget& begin(const SweepInput& input) = 0;
    /// After the scratch of the sweep has been released: completes result and summary.
    virtual void finish(const SweepInput& input) = 0;
    /// In place of these functions: a result that was made whole.
    virtual void take_whole(SliceResult& whole, const Parallel& parallel) = 0;

protected:
    ~LayerTarget() = default;
};

/// A slice that is made for SweepInput::result.
class ResultTarget final : public LayerTarget {
public:
    void admit(const SweepInput& input, std::uint64_t memory_limit) override;
    BandTarget& begin(const SweepInput& input) override;
    void finish(const SweepInput& input) override;
    /// Precondition: never, since `whole` is it.
    void take_whole(SliceResult& whole, const Parallel& parallel) override;
};

/// Has the arrays of `result` take their memory from there. Those that take it from elsewhere are emptied.
void move_to(const Memory* memory, SliceResult& result);

/// The layer of a plane, without its contours.
inline Layer describe_layer(const PlaneSet& planes, PlaneIndex plane, std::uint64_t segments) {
    return {planes.bottom_mm(plane),     planes.height_mm(plane), planes.top_mm(plane), 0, 0, segments,
            PlaneHeight(planes.z(plane))};
}

/// Writes all layers, without their contours, to `layers`.
void fill_layers(const SweepInput& input, std::span<Layer> layers);

/// SliceInfo::layers, layer_of, first_layer and planned_layers; `list_heights`: the options have not chosen them.
void describe_plan(const PlaneSet& planes, bool list_heights, SliceInfo& info);

/// Adds what a part of a slice has read, swept and spent.
void add_work(const SliceInfo& part, SliceInfo& sum) noexcept;

}  // namespace lamella
