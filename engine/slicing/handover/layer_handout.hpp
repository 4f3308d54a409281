// Takes layers out of the output of a band and hands them to the host's sink.
#pragma once

#include <cstdint>

#include "base/parallel.hpp"
#include "lamella/sink.hpp"
#include "slicing/result/slice_output.hpp"

namespace lamella {

/// What was handed over.
struct HandedOver {
    std::uint64_t layers = 0;
    std::uint64_t contours = 0;
    std::uint64_t points = 0;
    std::uint64_t closed_gaps = 0;
    std::uint64_t emptied = 0;  ///< layers that have segments but no contour
    ContourCounts counts;

    void add(const HandedOver& other) noexcept;
};

/// Immutable, shared by all threads.
class LayerHandout {
public:
    LayerHandout(const LayerSink& sink, const SweepInput& input) noexcept
        : sink_(sink),
          planes_(input.planes),
          buckets_(input.buckets),
          parallel_(input.parallel),
          unit_mm_(input.result.unit_mm),
          first_index_(input.first_index) {}

    /// Hands over all layers of `output` and empties it. Throws Stopped where the host wants the call to end.
    void hand_over(BandOutput& output, HandedOver& total) const;

private:
    const LayerSink& sink_;
    const PlaneSet& planes_;
    const Buckets& buckets_;
    const Parallel& parallel_;
    double unit_mm_;
    std::uint64_t first_index_;
};

}  // namespace lamella
