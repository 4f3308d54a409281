// Overlay's calls, as the list of their stages:
//
//     LayerSets        one grid, one set of planes; what the host gives lies on the grid
//     LayerOverlay,    each layer by one thread, side by side
//     LayerOffset,
//     LayerClip
//     LayerTarget      contours and points to their place

#include "lamella/overlay.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/function_ref.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/overlay/labels.hpp"
#include "slicing/overlay/layer_clip.hpp"
#include "slicing/overlay/layer_offset.hpp"
#include "slicing/overlay/layer_overlay.hpp"
#include "slicing/overlay/layer_sets.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slicer.hpp"

namespace lamella {

namespace detail {

struct OverlayImpl {
    explicit OverlayImpl(const Context& context)
        : memory(context.memory),
          parallel(context),
          output(memory),
          builders(static_cast<std::size_t>(parallel.threads())) {}

    /// What a thread works with.
    struct Builder {
        explicit Builder(const Parallel& parallel) : worker(parallel.memory(), parallel.stop()) {}
        Worker worker;
        LayerOverlay overlay{worker};
        LayerOffset offset{worker};
        LayerClip clip{worker};
    };

    Builder& of(int worker) {
        auto& builder = builders[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(parallel);
        }
        return *builder;
    }

    const Memory* memory;
    Parallel parallel;
    OutputScratch output;
    std::vector<std::unique_ptr<Builder>> builders;  ///< by worker
};

}  // namespace detail

namespace {

using Builder = detail::OverlayImpl::Builder;

/// Appends a layer of the answer, and returns its highest label.
using LayerWork = FunctionRef<std::uint32_t(Builder& by, PlaneIndex layer, BandOutput& out)>;

/// The same rules of what is a region already.
RegionRules of_region(RegionRules rules) {
    rules.fill_rule = FillRule::positive;
    rules.fill_from.clear();
    return rules;
}

/// What a call's operation makes of its sets.
struct Answer {
    std::uint64_t parts = 1;  ///< 0: not known
    double moved_mm = 0;      ///< how far beyond the sets it may reach
};

/// One call, whatever it does to a layer.
class OverlayCall {
public:
    /// Throws Refused where the sets do not go together.
    OverlayCall(std::unique_ptr<detail::OverlayImpl>& impl, const Destination& to, std::span<const LayerSet> sets,
                const Context& context)
        : to_(to), context_(context), sets_(elsewhere(sets, to)) {
        if (impl == nullptr || impl->memory != context.memory || !impl->parallel.serves(context)) {
            impl = std::make_unique<detail::OverlayImpl>(context);
        }
        kept_ = impl.get();
        kept_->parallel.follow(context.stop);
    }

    const LayerSets& sets() const noexcept { return sets_; }
    const LayerRules& rules() const noexcept { return rules_; }

    /// Throws Refused where `after` cannot be done to the answer.
    SliceInfo run(const Answer& answer, const RegionRules& after, LayerWork work);

private:
    static std::span<const LayerSet> elsewhere(std::span<const LayerSet> sets, const Destination& to) {
        for (const LayerSet& set : sets) {
            if (to.result() != nullptr && set.layers.stack() == to.result()) {
                throw Refused{{ErrorCode::invalid_argument, "the answer cannot take the place of one of the sets"}};
            }
        }
        return sets;
    }
    void fill(LayerTarget& target, LayerWork work);

    const Destination& to_;
    const Context& context_;
    LayerSets sets_;
    detail::OverlayImpl* kept_ = nullptr;
    SliceInfo of_others_;  // where the answer is no result
    SliceInfo& info_ = to_.result() != nullptr ? to_.result()->info : of_others_;
    LayerRules rules_;  // after the operation
};

SliceInfo OverlayCall::run(const Answer& answer, const RegionRules& after, LayerWork work) {
    AnyTarget any;
    LayerTarget& target = *target_of(&to_, context_.memory, any);  // a result is emptied
    const RegionRules rules = of_region(after);
    require(check_rules({.region = rules}));
    require(check_reach(rules, sets_.grid_mm(), sets_.farthest_mm() + answer.moved_mm));
    info_ = sets_.begin_info(rules, answer.moved_mm);
    info_.part_count = std::max<std::uint64_t>(answer.parts, 1);
    info_.threads = kept_->parallel.threads();
    rules_.grid_mm = sets_.grid_mm();
    rules_.region = &info_.options.region;
    fill(target, work);
    return to_.result() != nullptr ? SliceInfo(info_) : std::move(info_);
}

void OverlayCall::fill(LayerTarget& target, LayerWork work) {
    const auto start = Clock::now();
    const bool is_kept = to_.result() != nullptr;  // others take layers away
    const std::uint64_t most_bytes =
        is_kept ? detail::memory_limit(context_.memory_limit_bytes) : std::numeric_limits<std::uint64_t>::max();
    ProgressMeter progress(context_.progress);
    std::atomic<std::size_t> done = 0;
    std::atomic<std::uint64_t> bytes = 0;
    std::atomic<std::uint64_t> most_label = 0;
    const std::vector<Band> tasks = sets_.cut_tasks(info_.layers, kept_->parallel);
    const auto layer_at = [this](PlaneIndex layer) { return sets_.describe(layer); };
    target.admit_layers(info_.layers, info_);
    const OutputPlan plan{.layers = static_cast<PlaneIndex>(info_.layers),
                          .layer_at = layer_at,
                          .segments = 0,
                          .cutting = 0,
                          .bands = tasks,
                          .parallel = kept_->parallel,
                          .scratch = kept_->output,
                          .origins = false,
                          .info = info_};
    target.begin(plan);
    fill_bands(target, kept_->parallel, 0, tasks.size(), [&](std::size_t task, int worker, BandOutput& output) {
        for (PlaneIndex layer = tasks[task].first; layer < tasks[task].last; ++layer) {
            const std::uint64_t label = work(kept_->of(worker), layer, output);
            output.finish_layer();
            for (std::uint64_t before = most_label; before < label && !most_label.compare_exchange_weak(before, label);) {
            }
        }
        if ((bytes += output.point_count * sizeof(Point) + output.contours.size() * sizeof(Contour)) > most_bytes) {
            throw Refused{{ErrorCode::result_too_large,
                           "combined layers need more than the memory limit of " + std::to_string(most_bytes) + " bytes"}};
        }
        progress.reach(static_cast<double>(++done) / static_cast<double>(tasks.size()));
    });
    target.finish();
    info_.part_count = std::max<std::uint64_t>(info_.part_count, most_label);
    info_.ms.fill = milliseconds_since(start);
    progress.finish();
}

}  // namespace

Result<SliceInfo> Overlay::combine(const Destination& to, std::span<const LayerSet> sets, const Rule& rule,
                                   const RegionRules& after, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        OverlayCall call(impl_, to, sets, context);
        require(check_rule(rule, sets.size()));
        return call.run({.parts = parts_of(rule, sets.size())}, after, [&](Builder& by, PlaneIndex n, BandOutput& out) {
            return by.overlay.run(sets, rule, call.rules(), n, out);
        });
    });
}

Result<SliceInfo> Overlay::offset(const Destination& to, const LayerSet& of, std::span<const OffsetStep> steps,
                                  const OffsetOptions& options, const RegionRules& after, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        OverlayCall call(impl_, to, {&of, 1}, context);
        const OffsetPlan plan(steps, options, of, call.sets(), context.memory);
        return call.run(
            {.parts = plan.kept(), .moved_mm = plan.moved_mm()}, after,
            [&](Builder& by, PlaneIndex n, BandOutput& out) { return by.offset.run(of, plan, call.rules(), n, out); });
    });
}

Result<SliceInfo> Overlay::clip(const Destination& to, const Layers& lines, const LayerSet& by, const ClipOptions& options,
                                const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        const LayerSet sets[] = {{.layers = lines}, by};
        OverlayCall call(impl_, to, sets, context);
        return call.run({.parts = 0}, {}, [&](Builder& builder, PlaneIndex n, BandOutput& out) {
            return builder.clip.run(lines, by, options, call.sets().grid_mm(), n, out);
        });
    });
}

void Overlay::reset() noexcept {
    impl_.reset();
}

Overlay::Overlay() noexcept = default;
Overlay::~Overlay() = default;
Overlay::Overlay(Overlay&&) noexcept = default;
Overlay& Overlay::operator=(Overlay&&) noexcept = default;

}  // namespace lamella
