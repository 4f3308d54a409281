// Slicing, as the list of its stages. They call the folders beside this file:
//
//     TriangleSource::measure   grid       bounds, unit (paper, 3.1)
//     build_planes              planes     heights on the grid (Algorithm 3)
//     TriangleSource::count     buckets    how many triangles each plane is the first to cut (Algorithm 2)
//     BandPlan::cut             bands      ranges of planes, each swept by one thread; tiers of them
//     for each tier
//       TriangleSource::scatter   buckets    triangles to the first plane that cuts them
//       BandSweep, WidePlane      sweep      a band, or a wide plane by all threads (Algorithm 1)
//         for each plane            contours   links, walk (Algorithm 4)
//                                     repair     gaps closed, on request
//                                     regions    fill rule applied, on request
//                                     nesting    orientation, roles, parents (Fig. 1, step 4)
//         for each band             result     points to their place
//     LayerTarget::finish       result     contours and layers to their place, or what the output is
#include "slicing/slice_layers.hpp"

#include <algorithm>
#include <atomic>
#include <string>

#include "base/clock.hpp"
#include "base/parallel.hpp"
#include "base/system/processor.hpp"
#include "slicing/sweep/band_sweep.hpp"
#include "slicing/sweep/wide_plane.hpp"

namespace lamella {

namespace {

/// What bands are swept with, and how the time that this takes is split among its phases.
class Sweeps {
public:
    Sweeps(const SliceCall& call, const SliceInfo& info)
        : form_(call.tuning.form), kept_(call.kept), parallel_(*kept_.parallel) {
        rules_ = rules_for(call.options, info);
        rules_.first_layer = kept_.planes.first_kept();
        kept_.last_made_regions = !call.options.region.leaves_contours();
        kept_.sweeps_made_regions = kept_.sweeps_made_regions || kept_.last_made_regions;
        kept_.sweeps.resize(std::max(kept_.sweeps.size(), static_cast<std::size_t>(parallel_.threads())));
    }

    /// Bands [begin, the end of the stretch) are swept side by side: a wide one by itself.
    std::size_t end_of_stretch(std::size_t begin, std::size_t last) const noexcept {
        std::size_t end = begin + 1;
        while (end < last && !is_wide(begin) && !is_wide(end)) {
            ++end;
        }
        return end;
    }

    /// False, with nothing appended, where another way must be taken.
    bool sweep_wide(std::size_t band, BandOutput& output) {
        if (!is_wide(band)) {
            return false;
        }
        WidePlane wide(kept_.memory, kept_.instructions, parallel_, rules_);
        const std::uint64_t start = ticks();
        if (!wide.build(kept_.bands.bands[band].first, kept_.bands.seeds.of(band), kept_.buckets, kept_.planes, output)) {
            return false;
        }
        const std::uint64_t spent = ticks() - start;
        // As if all threads had swept it, and as one of the layers that stand for others.
        const auto share = [this](std::uint64_t own) {
            return own * static_cast<std::uint64_t>(parallel_.threads()) / BandSweep::timing_stride;
        };
        wide_ticks_.nesting += share(wide.ticks().nesting);
        wide_ticks_.fill += share(wide.ticks().fill);
        wide_ticks_.sweep += share(spent - wide.ticks().nesting - wide.ticks().fill);
        return true;
    }

    BandSweep& of(int worker) {
        auto& sweep = kept_.sweeps[static_cast<std::size_t>(worker)];
        if (sweep == nullptr) {
            sweep = std::make_unique<BandSweep>(kept_.memory, kept_.instructions);
        }
        sweep->set_rules(rules_);
        return *sweep;
    }

    /// Splits the wall time of the sweep among its stages, in proportion to the thread time of each in sampled layers.
    void split_time(double sweep_ms, StageTimes& ms) const {
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
        ms.contours = sweep_ms * static_cast<double>(spent.contours) / all;
        ms.nesting = sweep_ms * static_cast<double>(spent.nesting) / all;
        ms.fill = sweep_ms * static_cast<double>(spent.fill) / all;
        ms.sweep = sweep_ms - ms.contours - ms.nesting - ms.fill;
    }

private:
    bool is_wide(std::size_t band) const noexcept { return kept_.bands.bands[band].wide && form_ == ContourForm::swept; }

    ContourForm form_;
    detail::SlicerImpl& kept_;
    const Parallel& parallel_;
    LayerRules rules_;
    SweepTicks wide_ticks_;
};

/// Bands are cut between counting and scattering, so that scattering notes the triangles that reach beyond their band.
void cut_bands(std::uint64_t most_band_segments, const SliceCall& call, SliceInfo& info) {
    detail::SlicerImpl& kept = call.kept;
    kept.parallel->stop_if_asked();
    kept.bands.cut(kept.buckets, kept.planes.size(), static_cast<int>(call.tuning.band_planes), kept.parallel->threads(),
                   most_band_segments);
    info.crossed = kept.buckets.list_begin[kept.planes.size()];
    info.bands = kept.bands.bands.size();
    if (kept.bands.tiers.size() > 1) {  // room for any, rather than to grow
        kept.buckets.records.resize_discarding(kept.bands.most_records());
    }
}

void scatter(TriangleSource& source, const Tier& tier, const SliceCall& call) {
    detail::SlicerImpl& kept = call.kept;
    BandPlan& bands = kept.bands;
    const std::size_t reaching = source.scatter(tier.planes, bands.band_end, bands.reaching.span(), call.options.origins);
    bands.find_seeds(kept.planes.size(), reaching, *kept.parallel);
}

}  // namespace

void check_options(const SliceOptions& options, const Tuning& tuning) {
    if (tuning.band_planes < 0) {
        throw Refused{{ErrorCode::invalid_argument, "the number of planes in a band must not be negative"}};
    }
    if (tuning.instructions && !runs(*tuning.instructions)) {
        throw Refused{{ErrorCode::invalid_argument, "this processor, or this build of lamella, has no " +
                                                        std::string(name_of(*tuning.instructions)) + " instructions"}};
    }
    require(check_rules(options));
}

void count_layers(TriangleSource& source, const SliceCall& call, SliceInfo& info) {
    const auto& [options, tuning, context, kept] = call;
    const SharedFrame* const given = source.info.frame;
    const double asked_mm = given != nullptr ? given->unit.mm : options.frame.grid_mm;
    const bool is_empty = source.info.triangles == 0;
    const Bounds box = options.allow_empty && is_empty ? Bounds{} : source.measure(asked_mm);
    SharedFrame frame = given != nullptr ? *given : choose_frame(box, source.info.number, options.frame, options.region);
    // A frame's unit may have been chosen without these rules.
    require(check_reach(options.region, frame.unit.mm, box.farthest_in_plane()));
    begin_info(options, box, frame.unit, info);
    info.triangles = source.info.triangles;
    build_planes(call, frame, kept.planes);
    source.count(frame.unit.mm);
    if (kept.buckets.degenerate == info.triangles) {
        if (!options.allow_empty) {
            throw Refused{all_collapsed(info.triangles, frame.unit.mm)};
        }
        if (given == nullptr) {
            frame.bounds = {};  // the box of nothing chooses no planes
            build_planes(call, frame, kept.planes);
            source.count(frame.unit.mm);
        }
    }
    info.degenerate = kept.buckets.degenerate;
    info.segments = kept.buckets.segment_count;
    info.threads = kept.parallel->threads();
    describe_plan(kept.planes, tuning.random_heights.has_value(), info);
}

void slice_layers(TriangleSource& source, LayerTarget* target, const SliceCall& call, SliceInfo& info,
                  std::uint64_t first_index) {
    Clock::time_point start = Clock::now();
    detail::SlicerImpl& kept = call.kept;
    const Parallel& parallel = *kept.parallel;
    count_layers(source, call, info);
    if (target == nullptr) {
        return;
    }
    const std::span<const std::uint32_t> segments = kept.buckets.segments.span();
    const auto layer_at = [&](PlaneIndex plane) { return describe_layer(kept.planes, plane, segments[plane]); };
    const auto cutting = std::count_if(segments.begin(), segments.end(), [](std::uint32_t count) { return count > 0; });
    OutputPlan plan{.layers = kept.planes.size(),
                    .layer_at = layer_at,
                    .segments = kept.buckets.segment_count,
                    .cutting = static_cast<std::uint64_t>(cutting),
                    .bands = {},
                    .parallel = parallel,
                    .scratch = kept.output,
                    .origins = call.options.origins,
                    .info = info,
                    .first_index = first_index};
    target->admit(plan, call.memory_limit());

    cut_bands(target->most_band_segments(parallel.threads()), call, info);
    const Vector<Band>& bands = kept.bands.bands;
    plan.bands = bands;

    ProgressMeter progress(call.context.progress);
    Sweeps sweeps(call, info);
    std::atomic<std::uint64_t> segments_done = 0;
    target->begin(plan);
    const auto sweep = [&](std::size_t band, int worker, BandOutput& output) {
        if (!sweeps.sweep_wide(band, output)) {
            sweeps.of(worker).run(bands[band], kept.bands.seeds.of(band), kept.buckets, kept.planes, call.tuning.form,
                                  parallel.stop(), output);
        }
        const std::uint64_t done = segments_done += bands[band].segments;
        progress.reach(static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(1, plan.segments)));
    };
    double sweep_ms = 0;
    for (const Tier& tier : kept.bands.tiers) {
        scatter(source, tier, call);
        info.ms.bucket += milliseconds_since(start);
        start = Clock::now();
        for (std::size_t begin = tier.first_band, end = 0; begin < tier.last_band; begin = end) {
            end = sweeps.end_of_stretch(begin, tier.last_band);
            fill_bands(*target, parallel, begin, end, sweep);
        }
        sweep_ms += milliseconds_since(start);
        start = Clock::now();
    }
    source.give_back();
    kept.bands.forget_many_seeds();  // before the result's contours are added to what is held
    sweeps.split_time(sweep_ms, info.ms);

    start = Clock::now();
    target->finish();
    info.ms.contours += milliseconds_since(start);
    progress.finish();
}

}  // namespace lamella
