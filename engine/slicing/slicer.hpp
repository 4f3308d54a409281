// Scratch that is kept from call to call.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/counted_memory.hpp"
#include "base/parallel.hpp"
#include "lamella/slice.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/sweep/band_sweep.hpp"

namespace lamella::detail {

/// Half of physical memory: what results may take where the caller says nothing. The system takes half a microsecond for it.
std::uint64_t usual_memory_limit();

struct SlicerImpl {
    explicit SlicerImpl(const Memory* host);

    /// What the slicer keeps, for a call that begins on this thread. Where the call's memory is another one, it is made
    /// anew.
    static SlicerImpl& of(Slicer& slicer, const Context& context);

    SourceTools source_tools() noexcept { return {*parallel, planes, buckets}; }

    std::size_t bytes() const noexcept;
    /// See Slicer::trim(). Throws std::bad_alloc.
    void trim();

    CountedMemory counted;
    const Memory* memory = counted.memory();
    std::uint64_t usual_limit;
    std::unique_ptr<Parallel> parallel;  // kept, since threads return sooner to an arena that they have just left
    PlaneSet planes{memory};
    Buckets buckets{memory};
    BandPlan bands{memory};
    std::vector<std::unique_ptr<BandSweep>> sweeps;  // by worker
    bool sweeps_made_regions = false;                // one of them, since it was made
    bool last_made_regions = false;
    OutputScratch output{memory};
};

}  // namespace lamella::detail
