#include "slicing/regions/rules.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "base/words.hpp"
#include "lamella/grid.hpp"
#include "options/option_words.hpp"

namespace lamella {

namespace {

Error refusal(std::string message) {
    return {ErrorCode::invalid_argument, std::move(message)};
}

struct NamedLength {
    std::string_view name;
    double mm;
    bool moves_edges;
};

std::array<NamedLength, 4> lengths_of(const RegionRules& rules) {
    return {{{"the closing radius", rules.closing_mm, true},
             {"the offset", rules.offset_mm, true},
             {"the radius of the mark for near contours", rules.flag_closing_mm, true},
             {"the tolerance of simplification", rules.simplify_mm, false}}};
}

Status check_layers(const RegionRules& rules) {
    const auto& from = rules.fill_from;
    constexpr std::size_t rules_known = detail::words_of(FillRule{}).size();
    if (std::any_of(from.begin(), from.end(),
                    [](const FillFrom& own) { return static_cast<std::size_t>(own.rule) >= rules_known; })) {
        return refusal("fill_from has a rule that is none of its choices");
    }
    for (std::size_t i = 1; i < from.size(); ++i) {
        if (from[i].first_layer <= from[i - 1].first_layer) {
            return refusal("fill rules by layer must be in ascending order: one from layer " +
                           std::to_string(from[i - 1].first_layer) + " on stands before one from layer " +
                           std::to_string(from[i].first_layer) + " on");
        }
    }
    return {};
}

/// As moved_mm(), and how far contours would move that are only flagged.
double reach_of(const RegionRules& rules) noexcept {
    return std::max(moved_mm(rules), std::max(2.0, rules.miter_limit) * rules.flag_closing_mm);
}

std::optional<std::uint64_t> first_layer_of_contours(const RegionRules& rules) {
    if (rules.rule_of(0) == FillRule::contours) {
        return 0;
    }
    const auto found = std::find_if(rules.fill_from.begin(), rules.fill_from.end(),
                                    [](const FillFrom& from) { return from.rule == FillRule::contours; });
    return found == rules.fill_from.end() ? std::nullopt : std::optional<std::uint64_t>(found->first_layer);
}

}  // namespace

double moved_mm(const RegionRules& rules) noexcept {
    return std::max(2.0, rules.miter_limit) * (rules.closing_mm + std::abs(rules.offset_mm));
}

bool keeps_solid(const RegionRules& rules) noexcept {
    const auto serves = [](FillRule rule) { return rule == FillRule::contours || rule == FillRule::non_zero; };
    return serves(rules.fill_rule) &&
           std::all_of(rules.fill_from.begin(), rules.fill_from.end(),
                       [&](const FillFrom& from) { return serves(from.rule); }) &&
           moved_mm(rules) == 0 && !rules.largest_only && rules.simplify_mm == 0;
}

RegionRules working_rules(const SliceOptions& options) {
    RegionRules rules = options.region;
    if (options.content != LayerContent::section && rules.keeps_contours()) {
        rules.fill_rule = FillRule::positive;
    }
    return rules;
}

Status check_rules(const SliceOptions& options) {
    if (Status status = check_limits(options); !status) {
        return status;
    }
    const RegionRules rules = working_rules(options);
    if (Status status = check_layers(rules); !status) {
        return status;
    }
    const std::string_view what = needing_region(options);
    return what.empty() ? Status() : check_every_layer(rules, what);
}

Status check_every_layer(const RegionRules& rules, std::string_view what) {
    if (const auto layer = first_layer_of_contours(rules)) {
        return refusal(std::string(what) + " needs a region, but layer " + std::to_string(*layer) +
                       " has the fill rule contours, which makes none; choose another rule, such as non-zero");
    }
    return {};
}

Result<ChosenUnit> choose_unit_for(const Bounds& bounds, double asked_mm, bool coarser, const RegionRules& rules) {
    Result<ChosenUnit> unit = choose_unit(bounds, asked_mm, coarser, reach_of(rules));
    if (unit) {
        if (const Status status = check_reach(rules, unit->mm, bounds.farthest_in_plane()); !status) {
            return status.error();
        }
    }
    return unit;
}

Status check_reach(const RegionRules& rules, double unit_mm, double farthest_mm) {
    const double most_mm = grid_limit * unit_mm / std::max(1.0, rules.miter_limit);
    for (const NamedLength& length : lengths_of(rules)) {
        const double mm = std::abs(length.mm);
        if (mm > most_mm && length.moves_edges) {
            return refusal(std::string(length.name) + " of " + exact_text(length.mm) +
                           " mm is beyond the grid: with a unit of " + exact_text(unit_mm) + " mm and a miter limit of " +
                           exact_text(rules.miter_limit) + " it is at most " + exact_text(most_mm) + " mm");
        }
        if (mm > 0 && mm < unit_mm) {
            return refusal(std::string(length.name) + " of " + exact_text(length.mm) + " mm is under the grid unit of " +
                           exact_text(unit_mm) + " mm: nothing would happen");
        }
    }
    const double reach = reach_of(rules);
    if (reach > 0 && farthest_mm + reach > grid_limit * unit_mm) {
        return refusal("contours that extend to " + exact_text(farthest_mm) +
                       " mm from zero could be offset beyond the grid, " + "which ends at " +
                       exact_text(grid_limit * unit_mm) + " mm; choose a unit of more than " + exact_text(unit_mm) + " mm");
    }
    return {};
}

}  // namespace lamella
