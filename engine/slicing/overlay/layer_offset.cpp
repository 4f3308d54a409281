#include "slicing/overlay/layer_offset.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

namespace {

Refused bad_offset(std::string message) {
    return Refused{{ErrorCode::invalid_argument, std::move(message)}};
}

}  // namespace

OffsetPlan::OffsetPlan(std::span<const OffsetStep> steps, const OffsetOptions& options, const LayerSet& of,
                       const LayerSets& sets, const Memory* memory)
    : join_(options.join),
      end_(options.end),
      miter_limit_(options.miter_limit),
      tolerance_(options.arc_tolerance_mm / sets.grid_mm()) {
    if (steps.empty() || steps.size() > most_labels) {
        throw bad_offset("an offset has from 1 to " + std::to_string(most_labels) + " steps, not " +
                         std::to_string(steps.size()));
    }
    check(options, of);
    for (const OffsetStep& step : steps) {
        try {
            add(step, options, sets, memory);
        } catch (Refused& refused) {
            refused.error.message = "step " + std::to_string(steps_.size()) + ": " + refused.error.message;
            throw;
        }
    }
    if (kept_ == 0) {
        throw bad_offset("no step of the offset is kept");
    }
}

void OffsetPlan::check(const OffsetOptions& options, const LayerSet& of) const {
    if (options.join > Join::square || options.end > End::round) {
        throw bad_offset("the join or the end of an offset is none of its choices");
    }
    if (!(options.arc_tolerance_mm > 0) || !std::isfinite(options.arc_tolerance_mm)) {
        throw bad_offset("the arc tolerance must be finite and above 0, not " + exact_text(options.arc_tolerance_mm) +
                         " mm");
    }
    if (is_of_lines() && of.grow_mm != 0) {
        throw bad_offset("lines cannot be grown first: they bound no region");
    }
}

void OffsetPlan::add(const OffsetStep& step, const OffsetOptions& options, const LayerSets& sets, const Memory* memory) {
    const RegionRules rules{.fill_rule = FillRule::positive, .offset_mm = step.mm, .miter_limit = options.miter_limit};
    require(check_rules({.region = rules}));
    if (step.mm == 0 || (steps_.empty() && is_of_lines() && step.mm < 0)) {
        throw bad_offset(step.mm == 0
                             ? "the offset of 0 mm moves nothing"
                             : "lines have no inside: the first offset must be above 0, not " + exact_text(step.mm) + " mm");
    }
    require(check_reach(rules, sets.grid_mm(), sets.farthest_mm() + moved_mm_));
    const double least_mm = ArcDirections::least_tolerance * std::abs(step.mm);
    if (options.arc_tolerance_mm < least_mm && (join_ != Join::miter || end_ == End::round)) {
        throw bad_offset("an arc tolerance of " + exact_text(options.arc_tolerance_mm) +
                         " mm is too fine for an offset of " + exact_text(step.mm) + " mm, where it is at least " +
                         exact_text(least_mm) + " mm");
    }
    moved_mm_ += step.mm > 0 ? lamella::moved_mm(rules) : 0;
    kept_ += step.keep ? 1 : 0;
    Step& own = steps_.emplace_back(Step{step.mm / sets.grid_mm(), step.keep, ArcDirections(memory)});
    own.arcs.fit(std::abs(own.distance), tolerance_);
}

/// Where corners are round or square, a miter within the tolerance of the distance is left alone.
double OffsetPlan::limit_of(const Step& step) const noexcept {
    return join_ == Join::miter ? miter_limit_ : 1 + tolerance_ / std::abs(step.distance);
}

std::uint32_t LayerOffset::run(const LayerSet& of, const OffsetPlan& plan, const LayerRules& after, std::uint64_t n,
                               BandOutput& out) {
    layers_.rules = &after;
    if (!plan.is_of_lines()) {
        regions_.start_from(reader_.list_region(of, n, after.grid_mm, nester_));
    }
    std::uint32_t contours = 0;
    std::uint32_t part = 0;
    bool is_first = true;
    for (const OffsetPlan::Step& step : plan.steps()) {
        if (std::exchange(is_first, false) && plan.is_of_lines()) {
            regions_.widen(reader_.list_lines(of, n), step.distance, plan.corners_of(step), nester_);
        } else {
            regions_.move(step.distance, plan.corners_of(step), nester_);
        }
        if (step.keep) {
            contours += layers_.append_region(regions_.moved(), part++, out);
        }
        if (regions_.paths().empty()) {
            break;
        }
    }
    out.layer_contours.push_back(contours);
    return part;
}

}  // namespace lamella
