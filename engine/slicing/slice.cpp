// Slicing, as the list of its stages. They call the folders beside this file:
//
//     choose_grid_and_planes    grid       bounds, unit (paper, 3.1)
//                               planes     heights on the grid
//     bucket_triangles          buckets    triangles to the first plane that cuts them (Algorithm 2)
//                               bands      ranges of planes, each swept by one thread
//     sweep_bands               sweep      a band, or a wide plane by all threads (Algorithm 1)
//       for each plane            contours   links, walk (Algorithm 4)
//                                   repair     gaps closed, on request
//                                   regions    fill rule applied, on request
//                                   nesting    orientation, roles, parents (Fig. 1, step 4)
//       for each band             result     points to their place
//     finish_result             result     contours and layers to their place
#include "lamella/slice.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "lamella/memory.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/buckets/prepared_triangles.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/prepared_parts.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/placement.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/sweep/wide_plane.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

namespace {

/// One call of slice().
class Slicing {
public:
    /// `prepared`: null where triangles are read from `mesh`. `frame`: null where the mesh's own box chooses grid and
    /// planes.
    Slicing(const MeshView& mesh, const detail::PreparedParts* prepared, const SliceOptions& options,
            const SharedFrame* frame, detail::WorkspaceParts& kept, SliceResult& result)
        : mesh_(mesh),
          prepared_(prepared),
          options_(options),
          frame_(frame),
          kept_(kept),
          result_(result),
          progress_(options.control.progress),
          parallel_(kept.parallel_for(options.control)) {}

    Status run() {
        if (Status status = choose_grid_and_planes(); !status) {
            return status;
        }
        if (Status status = bucket_triangles(); !status) {
            return status;
        }
        result_.summary.ms.bucket = end_stage();
        if (Status status = sweep_bands(); !status) {
            return status;
        }
        finish_result();
        progress_.finish();
        return {};
    }

private:
    Status choose_grid_and_planes();
    Status bucket_triangles();
    Status sweep_bands();
    void sweep_all_into(std::span<Point> points);
    void sweep_band(std::size_t band, int worker);
    void sweep_wide(std::size_t band);
    std::uint64_t memory_limit() const noexcept {
        return options_.memory_limit_bytes != 0 ? options_.memory_limit_bytes : kept_.usual_limit;
    }
    LayerRules rules() const noexcept {
        return {&options_.region, result_.unit_mm, options_.close_gaps_mm / result_.unit_mm};
    }
    /// Milliseconds since the stage before ended.
    double end_stage() noexcept {
        const auto before = std::exchange(stage_began_, Clock::now());
        return std::chrono::duration<double, std::milli>(stage_began_ - before).count();
    }
    void note_ticks_of(const WidePlane& wide, std::uint64_t spent);
    void split_time(double sweep_ms);
    void finish_result();
    void fill_layers();
    void summarise();

    const MeshView& mesh_;
    const detail::PreparedParts* prepared_;
    const SliceOptions& options_;
    const SharedFrame* frame_;
    detail::WorkspaceParts& kept_;
    SliceResult& result_;
    ProgressMeter progress_;
    const Parallel& parallel_;
    SweepTicks wide_ticks_;
    Clock::time_point stage_began_ = Clock::now();
};

Status Slicing::choose_grid_and_planes() {
    const double asked_mm = frame_ != nullptr ? frame_->unit_mm : options_.unit_mm;
    if (prepared_ != nullptr) {
        kept_.blocks.blocks.set_size(0);
    }
    const Result<Bounds> bounds = prepared_ != nullptr
                                      ? prepared_->frame.bounds
                                      : measure_bounds(mesh_, options_.transform, asked_mm, parallel_, kept_.blocks);
    if (!bounds) {
        return bounds.error();
    }
    const Result<double> unit = frame_ != nullptr ? frame_->unit_mm : choose_unit(*bounds, asked_mm);
    if (!unit) {
        return unit.error();
    }
    if (Status status = check_reach(options_.region, *unit, bounds->farthest_in_plane()); !status) {
        return status;
    }
    result_.unit_mm = *unit;
    result_.frame = prepared_ != nullptr ? prepared_->transform : options_.transform;
    result_.plan = options_.plan;
    result_.part_count = 1;
    result_.part_regions = PartRegions::separate;
    result_.region = options_.region;
    result_.close_gaps_mm = options_.close_gaps_mm;
    result_.summary = {};
    std::copy_n(bounds->min_mm, 3, result_.summary.min_mm);
    std::copy_n(bounds->max_mm, 3, result_.summary.max_mm);
    if (frame_ != nullptr) {
        return kept_.planes.build(options_.plan, frame_->bounds, *unit, frame_->number, memory_limit());
    }
    const CoordinateType number = options_.transform.is_identity() ? mesh_.coordinate_type : CoordinateType::f64;
    return kept_.planes.build(options_.plan, *bounds, *unit, number, memory_limit());
}

/// Bands are cut between counting and scattering, so that scattering notes the triangles that reach beyond their band. The
/// size of the result is known, and refused if too large, before anything of that size is allocated.
Status Slicing::bucket_triangles() {
    Buckets& buckets = kept_.buckets;
    if (prepared_ != nullptr) {
        count_crossings(prepared_->triangles, kept_.planes, parallel_, buckets);
    } else {
        count_crossings(mesh_, options_.transform, result_.unit_mm, kept_.blocks, kept_.planes, parallel_, buckets);
    }
    if (buckets.degenerate == mesh_.triangle_count) {
        return all_collapsed(mesh_.triangle_count, result_.unit_mm);
    }
    const auto cutting =
        std::count_if(buckets.segments.begin(), buckets.segments.end(), [](auto count) { return count > 0; });
    const std::uint64_t bytes = buckets.segment_count * sizeof(Point) + kept_.planes.size() * sizeof(Layer) +
                                static_cast<std::uint64_t>(cutting) * sizeof(Contour);
    if (bytes > memory_limit()) {
        return Error{ErrorCode::result_too_large, counted(kept_.planes.size(), "layer") + " with " +
                                                      counted(buckets.segment_count, "segment") + " need " +
                                                      std::to_string(bytes) + " bytes, more than the memory limit of " +
                                                      std::to_string(memory_limit())};
    }
    parallel_.stop_if_asked();
    BandPlan& bands = kept_.bands;
    bands.cut(buckets, kept_.planes.size(), options_.tuning.band_planes, parallel_.threads());
    const std::size_t reaching = prepared_ != nullptr
                                     ? scatter_triangles(prepared_->triangles, kept_.planes, bands.band_end, parallel_,
                                                         buckets, bands.reaching.span())
                                     : scatter_triangles(mesh_, options_.transform, result_.unit_mm, kept_.planes,
                                                         bands.band_end, parallel_, buckets, bands.reaching.span());
    bands.find_seeds(kept_.planes.size(), reaching, options_.control.stop);
    return {};
}

Status Slicing::sweep_bands() {
    kept_.last_made_regions = !options_.region.keeps_contours() || options_.region.mark_near_mm > 0;
    kept_.sweeps_made_regions = kept_.sweeps_made_regions || kept_.last_made_regions;
    kept_.sweeps.resize(std::max(kept_.sweeps.size(), static_cast<std::size_t>(parallel_.threads())));

    // A closed contour has at most as many points as segments; an open one has one more, for which there is some room. A
    // mesh with very many open polylines needs more room and is swept again with the number of points counted.
    std::uint64_t room = kept_.buckets.segment_count + kept_.buckets.segment_count / 64 + 64;
    for (;;) {
        result_.points.resize_discarding(room);
        sweep_all_into(result_.points.span());
        const std::uint64_t needed = kept_.placement.point_count();
        if (needed <= room) {
            result_.points.set_size(needed);
            break;
        }
        room = needed;
    }
    kept_.bands.forget_many_seeds();  // before the result's contours are added to what is held
    split_time(end_stage());
    return {};
}

/// Wide planes by all threads, the bands between them by one thread each.
void Slicing::sweep_all_into(std::span<Point> points) {
    const auto& bands = kept_.bands.bands;
    kept_.placement.begin(bands, parallel_.threads(), kept_.buckets.segment_count, points, progress_, options_.control.stop);
    for (std::size_t begin = 0; begin < bands.size();) {
        parallel_.stop_if_asked();
        if (bands[begin].wide && options_.tuning.form == ContourForm::swept) {
            sweep_wide(begin++);
            continue;
        }
        std::size_t end = begin + 1;
        while (end < bands.size() && !bands[end].wide) {
            ++end;
        }
        parallel_.run(end - begin, [&](std::size_t i, int worker) { sweep_band(begin + i, worker); });
        begin = end;
    }
}

void Slicing::sweep_band(std::size_t band, int worker) {
    auto& sweep = kept_.sweeps[static_cast<std::size_t>(worker)];
    Placement& placement = kept_.placement;
    try {
        if (sweep == nullptr) {
            sweep = std::make_unique<BandSweep>(kept_.memory);
        }
        sweep->set_rules(rules());
        if (BandOutput* output = placement.acquire(band); output != nullptr) {
            sweep->run(kept_.bands.bands[band], kept_.bands.seeds_of(band), kept_.buckets, kept_.planes,
                       options_.tuning.form, options_.control.stop, *output);
            placement.submit(band);
        }
    } catch (...) {
        placement.abort();
        throw;
    }
}

void Slicing::sweep_wide(std::size_t band) {
    WidePlane wide(kept_.memory, parallel_, options_.control.stop, rules());
    BandOutput* output = kept_.placement.acquire(band);
    if (output == nullptr) {
        return;
    }
    const std::uint64_t start = ticks();
    if (wide.build(kept_.bands.bands[band].first, kept_.bands.seeds_of(band), kept_.buckets, kept_.planes, *output)) {
        note_ticks_of(wide, ticks() - start);
        kept_.placement.submit(band);
    } else {
        kept_.placement.give_back(band);
        sweep_band(band, 0);
    }
}

/// As if all threads had swept it, and as one of the layers that stand for others.
void Slicing::note_ticks_of(const WidePlane& wide, std::uint64_t spent) {
    const auto share = [this](std::uint64_t own) {
        return own * static_cast<std::uint64_t>(parallel_.threads()) / BandSweep::timing_stride;
    };
    wide_ticks_.nesting += share(wide.nesting_ticks());
    wide_ticks_.fill += share(wide.fill_ticks());
    wide_ticks_.sweep += share(spent - wide.nesting_ticks() - wide.fill_ticks());
}

/// Splits the wall time of the sweep among its stages, in proportion to the thread time of each in sampled layers.
void Slicing::split_time(double sweep_ms) {
    SweepTicks spent = wide_ticks_;
    for (const auto& sweep : kept_.sweeps) {
        if (sweep != nullptr) {
            const SweepTicks own = sweep->take_ticks();
            spent.sweep += own.sweep;
            spent.contours += own.contours;
            spent.nesting += own.nesting;
            spent.fill += own.fill;
        }
    }
    const auto all =
        static_cast<double>(std::max<std::uint64_t>(1, spent.sweep + spent.contours + spent.nesting + spent.fill));
    StageTimes& ms = result_.summary.ms;
    ms.contours = sweep_ms * static_cast<double>(spent.contours) / all;
    ms.nesting = sweep_ms * static_cast<double>(spent.nesting) / all;
    ms.fill = sweep_ms * static_cast<double>(spent.fill) / all;
    ms.sweep = sweep_ms - ms.contours - ms.nesting - ms.fill;
}

void Slicing::finish_result() {
    result_.contours.resize_discarding(kept_.placement.contour_count());
    result_.layers.resize_discarding(kept_.planes.size());
    result_.closed_gaps.resize_discarding(kept_.placement.closed_gap_count());
    kept_.placement.write_closed_gaps(result_.closed_gaps.span(), options_.control.stop);
    fill_layers();
    kept_.placement.write_contours(parallel_, result_.contours.span(), result_.layers.span());
    summarise();
    result_.summary.ms.contours += end_stage();
}

void Slicing::fill_layers() {
    const PlaneSet& planes = kept_.planes;
    parallel_.run_ranges(planes.size(), 1 << 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto plane = static_cast<PlaneIndex>(i);
            result_.layers[i] = {planes.bottom_mm(plane),   planes.height_mm(plane),     planes.top_mm(plane), 0, 0,
                                 kept_.buckets.segments[i], PlaneHeight(planes.z(plane))};
        }
    });
}

void Slicing::summarise() {
    SliceSummary& summary = result_.summary;
    summary.triangles = mesh_.triangle_count;
    summary.degenerate = kept_.buckets.degenerate;
    summary.crossed = kept_.buckets.records.size();
    summary.segments = kept_.buckets.segment_count;
    summary.bands = kept_.bands.bands.size();
    summary.threads = parallel_.threads();
    set_counts(kept_.placement.contour_counts(), result_);
}

}  // namespace

Status detail::PartSlicer::slice(const MeshView& mesh, const SliceOptions& options, const SharedFrame* frame,
                                 Workspace& workspace, SliceResult& result) {
    return run(mesh, nullptr, options, frame, workspace, result);
}

Status detail::PartSlicer::slice(const PreparedParts& mesh, const SliceOptions& options, Workspace& workspace,
                                 SliceResult& result) {
    if (options.unit_mm != 0 && options.unit_mm != mesh.asked_unit_mm && options.unit_mm != mesh.frame.unit_mm) {
        return Error{ErrorCode::invalid_argument, "the mesh was prepared on another grid than the one asked for"};
    }
    if (!options.transform.is_identity() && options.transform.m != mesh.transform.m) {
        return Error{ErrorCode::invalid_argument, "the mesh was prepared with another transform than the one asked for"};
    }
    MeshView counted_only;
    counted_only.triangle_count = mesh.triangle_count;
    return run(counted_only, &mesh, options, &mesh.frame, workspace, result);
}

Status detail::PartSlicer::run(const MeshView& mesh, const PreparedParts* prepared, const SliceOptions& options,
                               const SharedFrame* frame, Workspace& workspace, SliceResult& result) {
    if (options.tuning.band_planes < 0) {
        return Error{ErrorCode::invalid_argument, "the number of planes in a band must not be negative"};
    }
    if (!(options.close_gaps_mm >= 0) || !std::isfinite(options.close_gaps_mm)) {
        return Error{ErrorCode::invalid_argument, "the length up to which gaps are closed must be finite and not negative"};
    }
    if (Status status = check_rules(options.region); !status) {
        return status;
    }
    std::unique_ptr<WorkspaceParts>& kept = workspace.parts_;
    if (kept == nullptr || kept->counted.host() != options.control.memory) {
        kept = std::make_unique<WorkspaceParts>(options.control.memory);
    }
    if (result.points.memory() != options.control.memory) {
        result = SliceResult(options.control.memory);
    }
    return Slicing(mesh, prepared, options, frame, *kept, result).run();
}

Status slice(const MeshView& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded(options.control, [&] { return detail::PartSlicer::slice(mesh, options, nullptr, workspace, result); });
}

Result<SliceResult> slice(const MeshView& mesh, const SliceOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        Workspace workspace;
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::slice(mesh, options, nullptr, workspace, result); !status) {
            return status.error();
        }
        return result;
    });
}

}  // namespace lamella
