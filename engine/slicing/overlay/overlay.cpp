// Overlay::combine(), as the list of its stages:
//
//     check_sets       one grid, one set of planes; what the host gives lies on the grid
//     begin            the answer's layers are those of the stacks
//     LayerOverlay     each layer by one thread, side by side
//     LayerTarget      contours and points to their place

#include "lamella/overlay.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "slicing/grid/exact.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/overlay/labels.hpp"
#include "slicing/overlay/layer_overlay.hpp"
#include "slicing/regions/rules.hpp"
#include "slicing/result/layer_target.hpp"
#include "slicing/slicer.hpp"

namespace lamella {

namespace detail {

struct OverlayImpl {
    explicit OverlayImpl(const Context& context)
        : memory(context.memory), parallel(context), output(memory), layers(static_cast<std::size_t>(parallel.threads())) {}

    /// What a thread works with.
    struct Builder {
        explicit Builder(const Parallel& parallel) : worker(parallel.memory(), parallel.stop()) {}
        Worker worker;
        LayerOverlay layer{worker};
    };

    LayerOverlay& of(int worker) {
        auto& builder = layers[static_cast<std::size_t>(worker)];
        if (builder == nullptr) {
            builder = std::make_unique<Builder>(parallel);
        }
        return builder->layer;
    }

    const Memory* memory;
    Parallel parallel;
    OutputScratch output;
    std::vector<std::unique_ptr<Builder>> layers;  ///< by worker
};

}  // namespace detail

namespace {

Refused bad_set(std::string message) {
    return Refused{{ErrorCode::invalid_argument, std::move(message)}};
}

double grid_of(const Layers& layers) noexcept {
    if (layers.stack() != nullptr) {
        return layers.stack()->info.grid_mm;
    }
    return layers.layer() != nullptr ? layers.layer()->grid_mm : layers.given()->grid_mm;
}

bool has_layers(const LayerSet& set) noexcept {
    return set.layers.stack() != nullptr || set.layers.layer() != nullptr || set.layers.given() != nullptr;
}

/// The same rules of what is a region already.
RegionRules of_region(RegionRules rules) {
    rules.fill_rule = FillRule::positive;
    rules.fill_from.clear();
    return rules;
}

/// The largest coordinate's magnitude.
std::int64_t farthest_of(const FlatBox& bounds) noexcept {
    if (exceeds(bounds.low, bounds.high)) {
        return 0;
    }
    const std::int64_t low = std::min(bounds.low.x, bounds.low.y);
    return std::max<std::int64_t>(-low, std::max(bounds.high.x, bounds.high.y));
}

/// One call of combine().
class Combining {
public:
    Combining(std::span<const LayerSet> sets, const Rule& rule, const RegionRules& after, detail::OverlayImpl& kept,
              SliceInfo& info)
        : sets_(sets), rule_(rule), kept_(kept), info_(info) {
        const RegionRules as_region = of_region(after);
        check_sets(as_region);
        begin(as_region);
    }

    /// `memory_limit`: bytes of points and contours.
    void run(LayerTarget& target, std::uint64_t memory_limit, ProgressMeter& progress) {
        const auto start = Clock::now();
        std::atomic<std::size_t> done = 0;
        std::atomic<std::uint64_t> bytes = 0;
        const std::vector<Band> tasks = cut_tasks();
        const auto layer_at = [this](PlaneIndex layer) { return describe(layer); };
        target.admit_layers(info_.layers, info_);
        const OutputPlan plan{.layers = static_cast<PlaneIndex>(info_.layers),
                              .layer_at = layer_at,
                              .segments = 0,
                              .cutting = 0,
                              .bands = tasks,
                              .parallel = kept_.parallel,
                              .scratch = kept_.output,
                              .origins = false,
                              .info = info_};
        target.begin(plan);
        fill_bands(target, kept_.parallel, 0, tasks.size(), [&](std::size_t task, int worker, BandOutput& output) {
            for (PlaneIndex layer = tasks[task].first; layer < tasks[task].last; ++layer) {
                const std::uint32_t label = kept_.of(worker).run(sets_, rule_, rules_, layer, output);
                output.finish_layer();
                raise(most_label_, label);
            }
            if ((bytes += output.point_count * sizeof(Point) + output.contours.size() * sizeof(Contour)) > memory_limit) {
                throw Refused{{ErrorCode::result_too_large, "combined layers need more than the memory limit of " +
                                                                std::to_string(memory_limit) + " bytes"}};
            }
            progress.reach(static_cast<double>(++done) / static_cast<double>(tasks.size()));
        });
        target.finish();
        info_.part_count = std::max<std::uint64_t>(info_.part_count, most_label_);
        info_.ms.fill = milliseconds_since(start);
        progress.finish();
    }

private:
    /// Throws Refused.
    void check_sets(const RegionRules& after);
    double check_set(std::size_t number);
    void check_planes(std::size_t number) const;
    FlatBox bounds_of(const Layers& layers) const;
    void widen_box(const Layers& layers, const FlatBox& points, double moved_mm);
    void begin(const RegionRules& after);

    static void raise(std::atomic<std::uint64_t>& most, std::uint64_t label) noexcept {
        for (std::uint64_t before = most; before < label && !most.compare_exchange_weak(before, label);) {
        }
    }

    Layer describe(PlaneIndex n) const {
        Layer layer;
        if (stack_ != nullptr) {
            layer = stack_->layers[n];
        }
        layer.first_contour = layer.contour_count = layer.segments = 0;
        for (const LayerSet& set : sets_) {
            layer.segments += set.layers.stack() != nullptr ? set.layers.stack()->layers[n].segments : 0;
        }
        return layer;
    }

    /// A few layers each.
    std::vector<Band> cut_tasks() const {
        constexpr std::uint64_t most_layers = 16;
        constexpr std::uint64_t enough_points = 1 << 14;
        std::vector<Band> tasks;
        std::uint64_t points = 0;
        for (PlaneIndex n = 0; n < info_.layers; ++n) {
            if (tasks.empty() || points >= enough_points || n - tasks.back().first >= most_layers) {
                kept_.parallel.stop_if_asked();
                tasks.push_back({n, n, 0, false});
                points = 0;
            }
            tasks.back().last = n + 1;
            for (const LayerSet& set : sets_) {
                points += set.layers.stack() != nullptr ? (*set.layers.stack())[n].points.size() : 0;
            }
        }
        return tasks;
    }

    std::span<const LayerSet> sets_;
    const Rule& rule_;
    detail::OverlayImpl& kept_;
    SliceInfo& info_;
    const SliceResult* stack_ = nullptr;  ///< the first; null: there is none
    std::optional<Box> box_;              ///< what the answer lies in
    std::atomic<std::uint64_t> most_label_{0};
    LayerRules rules_;  ///< after the sets are combined
};

void Combining::check_sets(const RegionRules& after) {
    if (sets_.empty() || sets_.size() > most_layer_sets) {
        throw bad_set("from 1 to " + std::to_string(most_layer_sets) + " sets of layers can be combined, not " +
                      std::to_string(sets_.size()));
    }
    require(check_rule(rule_, sets_.size()));
    const auto known = std::find_if(sets_.begin(), sets_.end(), has_layers);
    rules_.grid_mm = known == sets_.end() ? default_grid_mm : grid_of(known->layers);
    if (!(rules_.grid_mm > 0) || !std::isfinite(rules_.grid_mm)) {
        throw bad_set("the grid unit must be finite and above 0, not " + exact_text(rules_.grid_mm) + " mm");
    }
    double farthest = 0;
    for (std::size_t s = 0; s < sets_.size(); ++s) {
        try {
            farthest = std::max(farthest, check_set(s));
        } catch (Refused& refused) {
            refused.error.message = "set " + std::to_string(s) + ": " + refused.error.message;
            refused.error.part = static_cast<std::int64_t>(s);
            throw;
        }
    }
    require(check_rules({.region = after}));
    require(check_reach(after, rules_.grid_mm, farthest));
}

/// Returns how far the set's region may reach, in mm.
double Combining::check_set(std::size_t number) {
    const LayerSet& set = sets_[number];
    if (set.from > set.to) {
        throw bad_set("layers from " + std::to_string(set.from) + " to " + std::to_string(set.to) + " are none");
    }
    if (set.fill_rule == FillRule::contours || set.fill_rule == FillRule::outermost) {
        throw bad_set("the fill rule of a set is even-odd, non-zero or positive; others are done to a slice");
    }
    if (!has_layers(set)) {
        return 0;
    }
    if (grid_of(set.layers) != rules_.grid_mm) {
        throw bad_set("its grid unit is " + exact_text(grid_of(set.layers)) + " mm, and another set's " +
                      exact_text(rules_.grid_mm) + " mm: slice both on one grid");
    }
    const RegionRules grown{.fill_rule = set.fill_rule, .offset_mm = set.grow_mm};
    require(check_rules({.region = grown}));
    const FlatBox bounds = bounds_of(set.layers);
    const double farthest = static_cast<double>(farthest_of(bounds)) * rules_.grid_mm;
    require(check_reach(grown, rules_.grid_mm, farthest));
    widen_box(set.layers, bounds, moved_mm(grown));
    if (set.layers.stack() != nullptr) {
        stack_ = stack_ == nullptr ? set.layers.stack() : stack_;
        check_planes(number);
    }
    return farthest + moved_mm(grown);
}

void Combining::check_planes(std::size_t number) const {
    const SliceResult& own = *sets_[number].layers.stack();
    if (own.size() != stack_->size()) {
        throw bad_set("it has " + std::to_string(own.size()) + " layers, and another set " + std::to_string(stack_->size()));
    }
    for (std::size_t n = 0; n < own.size(); ++n) {
        if (own.layers[n].plane != stack_->layers[n].plane) {
            throw bad_set("its layer " + std::to_string(n) + " lies at " + exact_text(own[n].cut_mm()) +
                          " mm, and another set's at " + exact_text((*stack_)[n].cut_mm()) + " mm");
        }
    }
}

/// Throws Refused where a point lies beyond the grid.
FlatBox Combining::bounds_of(const Layers& layers) const {
    FlatBox bounds = FlatBox::nothing();
    const auto add = [&bounds](std::span<const Point> points) { bounds.include(FlatBox::around(points)); };
    if (layers.stack() != nullptr) {
        add(layers.stack()->points.span());
    } else if (layers.layer() != nullptr) {
        add(layers.layer()->points);
    } else {
        for (const std::span<const Point> contour : layers.given()->contours) {
            add(contour);
        }
    }
    const std::int64_t farthest = farthest_of(bounds);
    if (farthest > grid_limit) {
        throw bad_set("a point with the coordinate " + std::to_string(farthest) + " lies beyond the grid, which ends at " +
                      std::to_string(grid_limit) + " units");
    }
    return bounds;
}

/// By a stack's own box, and by points that lie farther out than rounding explains: two units.
void Combining::widen_box(const Layers& layers, const FlatBox& points, double moved_mm) {
    const auto include = [this](const Box& box) {
        box_ = box_.value_or(box);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box_->min_mm[axis] = std::min(box_->min_mm[axis], box.min_mm[axis]);
            box_->max_mm[axis] = std::max(box_->max_mm[axis], box.max_mm[axis]);
        }
    };
    if (layers.stack() != nullptr) {
        include(layers.stack()->info.box);
    }
    if (!exceeds(points.low, points.high)) {
        const double grid = rules_.grid_mm;
        const double out = moved_mm > 0 || layers.stack() == nullptr ? moved_mm : -2 * grid;
        Box box = box_.value_or(Box{});
        box.min_mm = {points.low.x * grid - out, points.low.y * grid - out, box.min_mm[2]};
        box.max_mm = {points.high.x * grid + out, points.high.y * grid + out, box.max_mm[2]};
        include(box);
    }
}

/// What is known of the answer before its layers.
void Combining::begin(const RegionRules& after) {
    SliceInfo info;
    if (stack_ != nullptr) {
        const SliceInfo& of = stack_->info;
        info.first_layer = of.first_layer;
        info.planned_layers = of.planned_layers;
        info.layer_of = of.layer_of;
        info.options = of.options;
    }
    info.box = box_.value_or(Box{});
    info.options.region = after;
    info.options.origins = false;
    info.options.unite_parts = false;
    info.part_count = std::max<std::uint64_t>(parts_of(rule_, sets_.size()), 1);
    info.grid_mm = rules_.grid_mm;
    info.layers = stack_ == nullptr ? 1 : stack_->size();
    info.threads = kept_.parallel.threads();
    for (const LayerSet& set : sets_) {
        info.segments += set.layers.stack() != nullptr ? set.layers.stack()->info.segments : 0;
    }
    info_ = std::move(info);
    rules_.region = &info_.options.region;
}

}  // namespace

Result<SliceInfo> Overlay::combine(const Destination& to, std::span<const LayerSet> sets, const Rule& rule,
                                   const RegionRules& after, const Context& context) noexcept {
    return guarded(context, [&]() -> Result<SliceInfo> {
        for (const LayerSet& set : sets) {
            if (to.result() != nullptr && set.layers.stack() == to.result()) {
                throw bad_set("the answer cannot take the place of one of the sets");
            }
        }
        if (impl_ == nullptr || impl_->memory != context.memory || !impl_->parallel.serves(context)) {
            impl_ = std::make_unique<detail::OverlayImpl>(context);
        }
        impl_->parallel.follow(context.stop);
        SliceInfo of_others;
        SliceInfo& info = to.result() != nullptr ? to.result()->info : of_others;
        AnyTarget any;
        LayerTarget& target = *target_of(&to, context.memory, any);
        ProgressMeter progress(context.progress);
        const bool is_kept = to.result() != nullptr;  // others take layers away
        const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
        Combining(sets, rule, after, *impl_, info)
            .run(target, is_kept ? detail::memory_limit(context.memory_limit_bytes) : most, progress);
        return to.result() != nullptr ? SliceInfo(info) : std::move(info);
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
