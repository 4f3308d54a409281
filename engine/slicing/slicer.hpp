// Scratch that is kept from call to call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "base/scratch_memory.hpp"
#include "lamella/array.hpp"
#include "lamella/slice.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/tuning.hpp"

namespace lamella::detail {

/// What results may take: as asked, or by 0 half of physical memory. The system takes half a microsecond for that.
std::uint64_t memory_limit(std::uint64_t asked = 0);

struct SlicerImpl {
    SlicerImpl(const Memory* host, InstructionSet level);

    /// What the slicer keeps, for a call that begins on this thread; made anew where memory or instructions differ.
    static SlicerImpl& of(Slicer& slicer, const Context& context, const Tuning& tuning);

    /// What a worker slices a small part with, all by itself. Precondition: there is a place for it in `sides`.
    SlicerImpl& side_of(int worker);

    SourceTools source_tools() noexcept { return {*parallel, planes, buckets, instructions}; }

    std::size_t bytes() const noexcept;
    /// True where the last call needed less than half of something: see Slicer::trim().
    bool holds_too_much() const noexcept;

    ScratchMemory scratch;
    const Memory* memory = scratch.memory();
    const InstructionSet instructions;
    std::uint64_t usual_limit;
    std::unique_ptr<Parallel> parallel;  // kept, since threads return sooner to an arena that they have just left
    PlaneSet planes{memory};
    Buckets buckets{memory};
    BandPlan bands{memory};
    std::vector<std::unique_ptr<BandSweep>> sweeps;  // by worker
    bool sweeps_made_regions = false;                // one of them, since it was made
    bool last_made_regions = false;
    OutputScratch output{memory};
    std::vector<std::unique_ptr<SlicerImpl>> sides;  // by worker, with scratch from this one's
};

}  // namespace lamella::detail
