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
//     finish_result             result     contours and layers to their place, or what the output is
//
// Triangles are read through triangle_source.
#include "lamella/slice.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "lamella/memory.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/prepared_parts.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/repair/gaps.hpp"
#include "slicing/result/result_output.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/sweep/wide_plane.hpp"
#include "slicing/triangle_source.hpp"
#include "slicing/workspace.hpp"

namespace lamella {

namespace {

/// One call of slice().
class Slicing {
public:
    Slicing(SliceOutput& output, const detail::SliceInput& input, const SliceOptions& options, detail::WorkspaceParts& kept,
            SliceResult& result)
        : output_(output),
          mesh_(input.mesh),
          prepared_(input.prepared),
          frame_(input.frame),
          first_index_(input.first_index),
          options_(options),
          kept_(kept),
          result_(result),
          progress_(options.control.progress),
          parallel_(kept.parallel_for(options.control)),
          source_(input, options, parallel_, kept) {}

    /// The size of the result is known, and refused if too large, before anything of that size is allocated.
    Status admit() {
        if (Status status = choose_grid_and_planes(); !status) {
            return status;
        }
        if (Status status = count_triangles(); !status) {
            return status;
        }
        return output_.admit(kept_.planes, kept_.buckets, result_, memory_limit());
    }

    Status run() {
        if (Status status = admit(); !status) {
            return status;
        }
        bucket_triangles();
        result_.summary.ms.bucket = end_stage();
        if (Status status = sweep_bands(); !status) {
            return status;
        }
        if (Status status = finish_result(); !status) {
            return status;
        }
        progress_.finish();
        return {};
    }

private:
    Status choose_grid_and_planes();
    Status build_planes(const Bounds& own);
    Status count_triangles();
    void bucket_triangles();
    Status sweep_bands();
    void sweep_all_into(BandTarget& target);
    void sweep_band(std::size_t band, int worker, BandTarget& target);
    void sweep_wide(std::size_t band, BandTarget& target);
    SweepInput sweep_input() noexcept {
        return {kept_.planes, kept_.buckets,    kept_.bands.bands, parallel_,   progress_,
                kept_.output, options_.origins, result_,           first_index_};
    }
    std::uint64_t memory_limit() const noexcept {
        return options_.memory_limit_bytes != 0 ? options_.memory_limit_bytes : kept_.usual_limit;
    }
    LayerRules rules() const noexcept {
        return {.region = &options_.region,
                .unit_mm = result_.unit_mm,
                .close_gaps = result_.close_gaps_mm / result_.unit_mm,
                .crossing_gaps = crossing_gap_mm(options_.close_gaps_mm, result_.close_gaps_mm) / result_.unit_mm,
                .gap_sense = options_.gap_sense,
                .first_layer = kept_.planes.first_kept()};
    }
    /// Milliseconds since the stage before ended.
    double end_stage() noexcept {
        const auto before = std::exchange(stage_began_, Clock::now());
        return std::chrono::duration<double, std::milli>(stage_began_ - before).count();
    }
    void note_ticks_of(const WidePlane& wide, std::uint64_t spent);
    void split_time(double sweep_ms);
    Status finish_result();
    void summarise();

    SliceOutput& output_;
    const MeshView& mesh_;
    const detail::PreparedParts* prepared_;
    const SharedFrame* frame_;
    std::uint64_t first_index_;
    const SliceOptions& options_;
    detail::WorkspaceParts& kept_;
    SliceResult& result_;
    ProgressMeter progress_;
    const Parallel& parallel_;
    TriangleSource source_;
    SweepTicks wide_ticks_;
    Clock::time_point stage_began_ = Clock::now();
};

Status Slicing::choose_grid_and_planes() {
    const double asked_mm = frame_ != nullptr ? frame_->unit.mm : options_.unit_mm;
    const Result<Bounds> bounds = source_.measure(asked_mm);
    if (!bounds) {
        return bounds.error();
    }
    const Result<ChosenUnit> unit =
        frame_ != nullptr ? frame_->unit : choose_unit_for(*bounds, asked_mm, options_.unit_fit, options_.region);
    if (!unit) {
        return unit.error();
    }
    // A frame's unit may have been chosen without these rules.
    if (Status status = check_reach(options_.region, unit->mm, bounds->farthest_in_plane()); !status) {
        return status;
    }
    result_.unit_mm = unit->mm;
    result_.frame = prepared_ != nullptr ? prepared_->transform : options_.transform;
    result_.plan = options_.plan;
    result_.part_count = 1;
    result_.part_regions = PartRegions::separate;
    result_.region = options_.region;
    result_.close_gaps_mm = gap_length_mm(options_.close_gaps_mm, *bounds);
    result_.gap_sense = options_.gap_sense;
    result_.summary = {};
    result_.summary.unit_doublings = unit->doublings;
    std::copy_n(bounds->min_mm, 3, result_.summary.min_mm);
    std::copy_n(bounds->max_mm, 3, result_.summary.max_mm);
    return build_planes(*bounds);
}

Status Slicing::build_planes(const Bounds& own) {
    const Bounds& bounds = frame_ != nullptr ? frame_->bounds : own;
    const CoordinateType number = frame_ != nullptr ? frame_->number : placed_number(mesh_, options_.transform);
    if (Status status = kept_.planes.build(options_.plan, bounds, result_.unit_mm, number, memory_limit()); !status) {
        return status;
    }
    return kept_.planes.keep(options_.layers);
}

Status Slicing::count_triangles() {
    source_.count(result_.unit_mm);
    if (kept_.buckets.degenerate == mesh_.triangle_count) {
        if (!options_.allow_empty) {
            return all_collapsed(mesh_.triangle_count, result_.unit_mm);
        }
        if (Status status = build_planes({}); !status) {  // the box of nothing chooses no planes
            return status;
        }
        source_.count(result_.unit_mm);
    }
    return {};
}

/// Bands are cut between counting and scattering, so that scattering notes the triangles that reach beyond their band.
void Slicing::bucket_triangles() {
    parallel_.stop_if_asked();
    Buckets& buckets = kept_.buckets;
    BandPlan& bands = kept_.bands;
    bands.cut(buckets, kept_.planes.size(), options_.tuning.band_planes, parallel_.threads(),
              output_.most_band_segments(parallel_.threads()));
    bands.find_seeds(kept_.planes.size(), source_.scatter(result_.unit_mm), parallel_.stop());
}

Status Slicing::sweep_bands() {
    kept_.last_made_regions = !options_.region.leaves_contours();
    kept_.sweeps_made_regions = kept_.sweeps_made_regions || kept_.last_made_regions;
    kept_.sweeps.resize(std::max(kept_.sweeps.size(), static_cast<std::size_t>(parallel_.threads())));
    if (Status status = output_.take_bands(sweep_input(), [this](BandTarget& target) { sweep_all_into(target); }); !status) {
        return status;
    }
    source_.give_back();
    kept_.bands.forget_many_seeds();  // before the result's contours are added to what is held
    split_time(end_stage());
    return {};
}

/// Wide planes by all threads, the bands between them by one thread each.
void Slicing::sweep_all_into(BandTarget& target) {
    const auto& bands = kept_.bands.bands;
    for (std::size_t begin = 0; begin < bands.size();) {
        parallel_.stop_if_asked();
        if (bands[begin].wide && options_.tuning.form == ContourForm::swept) {
            sweep_wide(begin++, target);
            continue;
        }
        std::size_t end = begin + 1;
        while (end < bands.size() && !bands[end].wide) {
            ++end;
        }
        parallel_.run(end - begin, [&](std::size_t i, int worker) { sweep_band(begin + i, worker, target); });
        begin = end;
    }
}

void Slicing::sweep_band(std::size_t band, int worker, BandTarget& target) {
    auto& sweep = kept_.sweeps[static_cast<std::size_t>(worker)];
    try {
        if (sweep == nullptr) {
            sweep = std::make_unique<BandSweep>(kept_.memory);
        }
        sweep->set_rules(rules());
        if (BandOutput* output = target.acquire(band); output != nullptr) {
            sweep->set_origins(output->with_origins);
            sweep->run(kept_.bands.bands[band], kept_.bands.seeds_of(band), kept_.buckets, kept_.planes,
                       options_.tuning.form, parallel_.stop(), *output);
            target.submit(band);
        }
    } catch (const BandDropped&) {  // the thread that has failed throws
    } catch (...) {
        target.abort();
        throw;
    }
}

void Slicing::sweep_wide(std::size_t band, BandTarget& target) {
    WidePlane wide(kept_.memory, parallel_, rules());
    BandOutput* output = target.acquire(band);
    if (output == nullptr) {
        return;
    }
    const std::uint64_t start = ticks();
    if (wide.build(kept_.bands.bands[band].first, kept_.bands.seeds_of(band), kept_.buckets, kept_.planes, *output)) {
        note_ticks_of(wide, ticks() - start);
        target.submit(band);
    } else {
        target.give_back(band);
        sweep_band(band, 0, target);
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

Status Slicing::finish_result() {
    const Vector<PlaneIndex>& listed = kept_.planes.plane_of_listed();
    result_.layer_of.resize_discarding(listed.size());
    std::copy(listed.begin(), listed.end(), result_.layer_of.begin());
    result_.first_layer = kept_.planes.first_kept();
    result_.all_layers = kept_.planes.planned();
    summarise();
    Status status = output_.finish(sweep_input());
    result_.summary.ms.contours += end_stage();
    return status;
}

void Slicing::summarise() {
    SliceSummary& summary = result_.summary;
    summary.triangles = mesh_.triangle_count;
    summary.degenerate = kept_.buckets.degenerate;
    summary.crossed = kept_.buckets.records.size();
    summary.segments = kept_.buckets.segment_count;
    summary.bands = kept_.bands.bands.size();
    summary.threads = parallel_.threads();
}

/// A prepared mesh has its grid and its frame already.
Status check_prepared(const detail::PreparedParts& prepared, const SliceOptions& options) {
    if (options.unit_mm != 0 && options.unit_mm != prepared.asked_unit_mm && options.unit_mm != prepared.frame.unit.mm) {
        return Error{ErrorCode::invalid_argument, "the mesh was prepared on another grid than the one asked for"};
    }
    if (!options.transform.is_identity() && !(options.transform == prepared.transform)) {
        return Error{ErrorCode::invalid_argument, "the mesh was prepared with another transform than the one asked for"};
    }
    return {};
}

Status check_options(const detail::SliceInput& input, const SliceOptions& options) {
    if (input.prepared != nullptr) {
        if (Status status = check_prepared(*input.prepared, options); !status) {
            return status;
        }
    }
    if (options.tuning.band_planes < 0) {
        return Error{ErrorCode::invalid_argument, "the number of planes in a band must not be negative"};
    }
    if (options.close_gaps_mm != gaps_by_mesh && (!(options.close_gaps_mm >= 0) || !std::isfinite(options.close_gaps_mm))) {
        return Error{ErrorCode::invalid_argument, "the length up to which gaps are closed must be finite and not negative"};
    }
    return check_rules(options.region);
}

detail::WorkspaceParts& parts_for(const SliceOptions& options, std::unique_ptr<detail::WorkspaceParts>& kept) {
    if (kept == nullptr || kept->counted.host() != options.control.memory) {
        kept = std::make_unique<detail::WorkspaceParts>(options.control.memory);
    }
    return *kept;
}

}  // namespace

Status detail::PartSlicer::slice(const SliceInput& input, const SliceOptions& options, Workspace& workspace,
                                 SliceResult& result) {
    ResultOutput output(options.origins);
    return slice_for(output, input, options, workspace, result);
}

Status detail::PartSlicer::slice_for(SliceOutput& output, const SliceInput& input, const SliceOptions& options,
                                     Workspace& workspace, SliceResult& result) {
    if (Status status = check_options(input, options); !status) {
        return status;
    }
    WorkspaceParts& kept = parts_for(options, workspace.parts_);
    if (result.points.memory() != options.control.memory) {
        result = SliceResult(options.control.memory);
    }
    return Slicing(output, input, options, kept, result).run();
}

Status detail::PartSlicer::admit(SliceOutput& output, const SliceInput& input, const SliceOptions& options,
                                 Workspace& workspace, SliceResult& result) {
    if (Status status = check_options(input, options); !status) {
        return status;
    }
    return Slicing(output, input, options, parts_for(options, workspace.parts_), result).admit();
}

Status slice(const MeshView& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded(options.control, [&] { return detail::PartSlicer::slice({mesh}, options, workspace, result); });
}

Result<SliceResult> slice(const MeshView& mesh, const SliceOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        Workspace workspace;
        SliceResult result(options.control.memory);
        if (Status status = detail::PartSlicer::slice({mesh}, options, workspace, result); !status) {
            return status.error();
        }
        return result;
    });
}

}  // namespace lamella
