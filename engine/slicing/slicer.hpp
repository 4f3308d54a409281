// Scratch that is kept from call to call.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/slice.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/triangle_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/tuning.hpp"

namespace lamella::detail {

/// Half of physical memory: what results may take where the caller says nothing. The system takes half a microsecond for it.
std::uint64_t usual_memory_limit();

/// The host's memory, or operator new's, with a count of what is taken of it.
class CountedMemory {
public:
    /// `host`: null for operator new.
    explicit CountedMemory(const Memory* host) noexcept : host_(host) {}
    CountedMemory(const CountedMemory&) = delete;  // referred to by what takes memory
    CountedMemory& operator=(const CountedMemory&) = delete;

    const Memory* host() const noexcept { return host_; }
    const Memory* memory() const noexcept { return &counting_; }
    /// Taken and not given back.
    std::size_t bytes() const noexcept { return bytes_.load(std::memory_order_relaxed); }

    /// For memory_of(). Arrays ask for no other alignment than what the host is asked for. Throws std::bad_alloc.
    void* allocate(std::size_t bytes, std::size_t /*alignment*/) {
        void* const block = take_memory(host_, bytes);
        bytes_.fetch_add(bytes, std::memory_order_relaxed);
        return block;
    }
    void deallocate(void* block, std::size_t bytes, std::size_t /*alignment*/) noexcept {
        bytes_.fetch_sub(bytes, std::memory_order_relaxed);
        give_memory(host_, block, bytes);
    }

private:
    const Memory* host_;
    std::atomic<std::size_t> bytes_ = 0;
    const Memory counting_ = memory_of(*this);
};

struct SlicerImpl {
    SlicerImpl(const Memory* host, InstructionSet level);

    /// What the slicer keeps, for a call that begins on this thread; made anew where memory or instructions differ.
    static SlicerImpl& of(Slicer& slicer, const Context& context, const Tuning& tuning);

    SourceTools source_tools() noexcept { return {*parallel, planes, buckets, instructions}; }

    std::size_t bytes() const noexcept;
    /// See Slicer::trim(). Throws std::bad_alloc.
    void trim();

    CountedMemory counted;
    const Memory* memory = counted.memory();
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
};

}  // namespace lamella::detail
