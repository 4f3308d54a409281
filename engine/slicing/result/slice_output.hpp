// What a slice is made for: a result in memory, a sink, the host's own arrays. The stages before the sweep are the same.
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
#include "slicing/buckets/bucket.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/band_target.hpp"
#include "slicing/result/placement.hpp"

namespace lamella {

/// Kept from call to call.
struct OutputScratch {
    explicit OutputScratch(const Memory* memory) : memory(memory), placement(memory) {}
    const Memory* memory;
    Placement placement;
    std::vector<std::unique_ptr<BandOutput>> outputs;  ///< of sinks
};

/// What is known when the sweep begins.
struct SweepInput {
    const PlaneSet& planes;
    const Buckets& buckets;
    std::span<const Band> bands;
    const Parallel& parallel;
    ProgressMeter& progress;
    OutputScratch& scratch;
    bool origins;                   ///< SliceOptions::origins
    SliceResult& result;            ///< unit, frame, plan and summary; arrays only where the slice is made for it
    std::uint64_t first_index = 0;  ///< of the first layer, for sinks
};

class SliceOutput {
public:
    /// The size is known, and nothing of that size is allocated yet: refuses what is too large. `result` holds unit, rules
    /// and box.
    virtual Status admit(const PlaneSet& planes, const Buckets& buckets, const SliceResult& result,
                         std::uint64_t memory_limit) = 0;
    /// How many segments a band should have at most.
    virtual std::uint64_t most_band_segments(int /*threads*/) const noexcept {
        return std::numeric_limits<std::uint64_t>::max();
    }
    /// Calls `sweep`, which sweeps all bands, once or more. Throws what it throws.
    virtual Status take_bands(const SweepInput& input, FunctionRef<void(BandTarget&)> sweep) = 0;
    /// After the scratch of the sweep has been released: completes result and summary.
    virtual Status finish(const SweepInput& input) = 0;

protected:
    ~SliceOutput() = default;
};

/// The layer of a plane, without its contours.
inline Layer describe_layer(const PlaneSet& planes, const Buckets& buckets, PlaneIndex plane) {
    return {planes.bottom_mm(plane), planes.height_mm(plane),     planes.top_mm(plane), 0, 0,
            buckets.segments[plane], PlaneHeight(planes.z(plane))};
}

/// Writes all layers, without their contours, to `layers`.
void fill_layers(const SweepInput& input, std::span<Layer> layers);

}  // namespace lamella
