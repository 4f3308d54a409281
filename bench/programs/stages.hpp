// The stages of slice(), callable one by one, with the memory that they reuse.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/mesh.hpp"
#include "lamella/slice.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/sweep/band_sweep.hpp"

namespace lamella::bench {

class Stages {
public:
    Stages(const MeshView& mesh, const LayerPlan& plan, int threads);

    Status measure();  ///< finds bounds and unit
    Status plan_planes();
    void count();
    void cut_bands();
    void scatter();
    void find_seeds();  ///< once after scatter(); may release the notes that scatter() made
    /// Sweeps every band into a buffer of its thread, without placement.
    void sweep(ContourForm form);
    /// Sweeps one band on this thread.
    void sweep_band(std::size_t band, ContourForm form);

    /// Runs every stage up to cut_bands().
    Status prepare();

    /// Cuts bands as for another number of threads. scatter() and find_seeds() must follow.
    void cut_bands_for(int threads);
    /// Makes look_at_bounds(), count(), cut_bands() and scatter() use `part` only, on the planes of the whole mesh.
    void narrow_to(const MeshView& part) {
        source_.emplace(part, Transform{}, nullptr, SourceTools{parallel_, planes_, buckets_});
    }
    /// Does the work of measure(), but keeps only the table of blocks.
    void look_at_bounds();

    const PlaneSet& planes() const noexcept { return planes_; }
    const Buckets& buckets() const noexcept { return buckets_; }
    const BandPlan& bands() const noexcept { return bands_; }
    std::uint64_t swept_contours() const noexcept;  ///< contours found by the last sweep()
    std::uint64_t swept_points() const noexcept;

private:
    struct Worker {
        Worker() : sweep(nullptr), output(nullptr) {}
        BandSweep sweep;
        BandOutput output;
        std::uint64_t contours = 0;
        std::uint64_t points = 0;
    };
    void sweep_on(Worker& worker, std::size_t band, ContourForm form);

    LayerPlan plan_;
    Parallel parallel_;
    Bounds bounds_{};
    double unit_mm_ = 0;
    PlaneSet planes_{nullptr};
    Buckets buckets_{nullptr};
    std::optional<SoupSource> source_;
    BandPlan bands_{nullptr};
    std::size_t reaching_ = 0;  // entries of bands_.reaching
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace lamella::bench
