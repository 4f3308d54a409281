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
#include <vector>

#include <unistd.h>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "lamella/memory.hpp"
#include "slicing/bands/bands.hpp"
#include "slicing/buckets/bucket.hpp"
#include "slicing/grid/bounds.hpp"
#include "slicing/grid/placed_reader.hpp"
#include "slicing/part_slicer.hpp"
#include "slicing/planes/plane_set.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/placement.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/sweep/wide_plane.hpp"

namespace lamella {

namespace {

std::uint64_t memory_limit(const SliceOptions& options) {
    if (options.memory_limit_bytes != 0) {
        return options.memory_limit_bytes;
    }
    const auto pages = static_cast<std::uint64_t>(std::max(0L, ::sysconf(_SC_PHYS_PAGES)));
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) / 2;
}

}  // namespace

/// Scratch that is kept from call to call.
struct detail::WorkspaceParts {
    explicit WorkspaceParts(const Memory* memory)
        : memory(memory), blocks(memory), planes(memory), buckets(memory), bands(memory), placement(memory) {}

    /// Kept, since threads return sooner to an arena that they have just left than to a new one.
    const Parallel& parallel_for(const Control& control) {
        if (parallel == nullptr || !parallel->serves(control)) {
            parallel = std::make_unique<Parallel>(control);
        }
        parallel->follow(control.stop);
        return *parallel;
    }

    const Memory* memory;
    std::unique_ptr<Parallel> parallel;
    BlockTable blocks;
    PlaneSet planes;
    Buckets buckets;
    BandPlan bands;
    std::vector<std::unique_ptr<BandSweep>> sweeps;  // by worker
    Placement placement;
};

Workspace::Workspace() noexcept = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

namespace {

/// One call of slice().
class Slicing {
public:
    /// `frame`: null where the mesh's own box chooses grid and planes.
    Slicing(const MeshView& mesh, const SliceOptions& options, const SharedFrame* frame, detail::WorkspaceParts& kept,
            SliceResult& result)
        : mesh_(mesh),
          options_(options),
          frame_(frame),
          kept_(kept),
          result_(result),
          progress_(options.control.progress),
          parallel_(kept.parallel_for(options.control)) {}

    Status run() {
        const auto start = Clock::now();
        if (Status status = choose_grid_and_planes(); !status) {
            return status;
        }
        if (Status status = bucket_triangles(); !status) {
            return status;
        }
        result_.summary.ms.bucket = milliseconds_since(start);
        if (Status status = sweep_bands(); !status) {
            return status;
        }
        finish_result();
        progress_.finish();
        return {};
    }

private:
    Status choose_grid_and_planes();
    Bounds no_bounds();
    Status build_planes(const Bounds& own);
    Status bucket_triangles();
    Status sweep_bands();
    void sweep_all_into(std::span<Point> points);
    void sweep_band(std::size_t band, int worker);
    void sweep_wide(std::size_t band);
    LayerRules rules() const noexcept {
        return {&options_.region, result_.unit_mm, options_.close_gaps_mm / result_.unit_mm};
    }
    void note_ticks_of(const WidePlane& wide, std::uint64_t spent);
    void split_time(double sweep_ms);
    void finish_result();
    void fill_layers();
    void summarise();

    const MeshView& mesh_;
    const SliceOptions& options_;
    const SharedFrame* frame_;
    detail::WorkspaceParts& kept_;
    SliceResult& result_;
    ProgressMeter progress_;
    const Parallel& parallel_;
    SweepTicks wide_ticks_;
};

Status Slicing::choose_grid_and_planes() {
    const double asked_mm = frame_ != nullptr ? frame_->unit.mm : options_.unit_mm;
    const Result<Bounds> bounds = options_.allow_empty && mesh_.triangle_count == 0
                                      ? no_bounds()
                                      : measure_bounds(mesh_, options_.transform, asked_mm, parallel_, kept_.blocks);
    if (!bounds) {
        return bounds.error();
    }
    const Result<ChosenUnit> unit =
        frame_ != nullptr ? frame_->unit : choose_unit(*bounds, asked_mm, options_.unit_fit == UnitFit::coarser_if_needed);
    if (!unit) {
        return unit.error();
    }
    if (Status status = check_reach(options_.region, unit->mm, bounds->farthest_in_plane()); !status) {
        return status;
    }
    result_.unit_mm = unit->mm;
    result_.frame = options_.transform;
    result_.plan = options_.plan;
    result_.part_count = 1;
    result_.part_regions = PartRegions::separate;
    result_.region = options_.region;
    result_.close_gaps_mm = options_.close_gaps_mm;
    result_.summary = {};
    result_.summary.unit_doublings = unit->doublings;
    std::copy_n(bounds->min_mm, 3, result_.summary.min_mm);
    std::copy_n(bounds->max_mm, 3, result_.summary.max_mm);
    return build_planes(*bounds);
}

Bounds Slicing::no_bounds() {
    kept_.blocks.blocks.resize_discarding(0);
    return {};
}

Status Slicing::build_planes(const Bounds& own) {
    const Bounds& bounds = frame_ != nullptr ? frame_->bounds : own;
    const CoordinateType number = frame_ != nullptr ? frame_->number : placed_number(mesh_, options_.transform);
    return kept_.planes.build(options_.plan, bounds, result_.unit_mm, number, memory_limit(options_));
}

/// Bands are cut between counting and scattering, so that scattering notes the triangles that reach beyond their band. The
/// size of the result is known, and refused if too large, before anything of that size is allocated.
Status Slicing::bucket_triangles() {
    Buckets& buckets = kept_.buckets;
    count_crossings(mesh_, options_.transform, result_.unit_mm, kept_.blocks, kept_.planes, parallel_, buckets);
    if (buckets.degenerate == mesh_.triangle_count) {
        if (!options_.allow_empty) {
            return all_collapsed(mesh_.triangle_count, result_.unit_mm);
        }
        if (Status status = build_planes({}); !status) {  // the box of nothing chooses no planes
            return status;
        }
        count_crossings(mesh_, options_.transform, result_.unit_mm, kept_.blocks, kept_.planes, parallel_, buckets);
    }
    const auto cutting =
        std::count_if(buckets.segments.begin(), buckets.segments.end(), [](auto count) { return count > 0; });
    const std::uint64_t bytes = buckets.segment_count * sizeof(Point) + kept_.planes.size() * sizeof(Layer) +
                                kept_.planes.plane_of_listed().size() * sizeof(std::uint64_t) +
                                static_cast<std::uint64_t>(cutting) * sizeof(Contour);
    if (bytes > memory_limit(options_)) {
        return Error{ErrorCode::result_too_large, counted(kept_.planes.size(), "layer") + " with " +
                                                      counted(buckets.segment_count, "segment") + " need " +
                                                      std::to_string(bytes) + " bytes, more than the memory limit of " +
                                                      std::to_string(memory_limit(options_))};
    }
    parallel_.stop_if_asked();
    BandPlan& bands = kept_.bands;
    bands.cut(buckets, kept_.planes.size(), options_.tuning.band_planes, parallel_.threads());
    const std::size_t reaching = scatter_triangles(mesh_, options_.transform, result_.unit_mm, kept_.planes, bands.band_end,
                                                   parallel_, buckets, bands.reaching.span());
    bands.find_seeds(kept_.planes.size(), reaching, options_.control.stop);
    return {};
}

Status Slicing::sweep_bands() {
    const auto start = Clock::now();
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
    split_time(milliseconds_since(start));
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
    const auto start = Clock::now();
    result_.contours.resize_discarding(kept_.placement.contour_count());
    result_.layers.resize_discarding(kept_.planes.size());
    result_.closed_gaps.resize_discarding(kept_.placement.closed_gap_count());
    kept_.placement.write_closed_gaps(result_.closed_gaps.span(), options_.control.stop);
    fill_layers();
    const std::vector<PlaneIndex>& listed = kept_.planes.plane_of_listed();
    result_.layer_of.resize_discarding(listed.size());
    std::copy(listed.begin(), listed.end(), result_.layer_of.begin());
    kept_.placement.write_contours(parallel_, result_.contours.span(), result_.layers.span());
    summarise();
    result_.summary.ms.contours += milliseconds_since(start);
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
    if (kept == nullptr || kept->memory != options.control.memory) {
        kept = std::make_unique<WorkspaceParts>(options.control.memory);
    }
    if (result.points.memory() != options.control.memory) {
        result = SliceResult(options.control.memory);
    }
    return Slicing(mesh, options, frame, *kept, result).run();
}

void Workspace::reset() noexcept {
    parts_.reset();
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
