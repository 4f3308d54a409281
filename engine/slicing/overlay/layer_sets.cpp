#include "slicing/overlay/layer_sets.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "slicing/regions/rules.hpp"

namespace lamella {

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

/// The largest coordinate's magnitude.
std::int64_t farthest_of(const FlatBox& bounds) noexcept {
    if (exceeds(bounds.low, bounds.high)) {
        return 0;
    }
    const std::int64_t low = std::min(bounds.low.x, bounds.low.y);
    return std::max<std::int64_t>(-low, std::max(bounds.high.x, bounds.high.y));
}

}  // namespace

LayerSets::LayerSets(std::span<const LayerSet> sets) : sets_(sets) {
    if (sets_.empty() || sets_.size() > most_layer_sets) {
        throw bad_set("from 1 to " + std::to_string(most_layer_sets) + " sets of layers can be combined, not " +
                      std::to_string(sets_.size()));
    }
    const auto known = std::find_if(sets_.begin(), sets_.end(), has_layers);
    grid_mm_ = known == sets_.end() ? default_grid_mm : grid_of(known->layers);
    if (!(grid_mm_ > 0) || !std::isfinite(grid_mm_)) {
        throw bad_set("the grid unit must be finite and above 0, not " + exact_text(grid_mm_) + " mm");
    }
    for (std::size_t s = 0; s < sets_.size(); ++s) {
        try {
            farthest_mm_ = std::max(farthest_mm_, check_set(sets_[s]));
        } catch (Refused& refused) {
            refused.error.message = "set " + std::to_string(s) + ": " + refused.error.message;
            refused.error.part = static_cast<std::int64_t>(s);
            throw;
        }
    }
}

/// Returns how far the set's region may reach, in mm.
double LayerSets::check_set(const LayerSet& set) {
    if (set.from > set.to) {
        throw bad_set("layers from " + std::to_string(set.from) + " to " + std::to_string(set.to) + " are none");
    }
    if (set.fill_rule == FillRule::contours || set.fill_rule == FillRule::outermost) {
        throw bad_set("the fill rule of a set is even-odd, non-zero or positive; others are done to a slice");
    }
    if (!has_layers(set)) {
        return 0;
    }
    if (grid_of(set.layers) != grid_mm_) {
        throw bad_set("its grid unit is " + exact_text(grid_of(set.layers)) + " mm, and another set's " +
                      exact_text(grid_mm_) + " mm: slice both on one grid");
    }
    const RegionRules grown{.fill_rule = set.fill_rule, .offset_mm = set.grow_mm};
    require(check_rules({.region = grown}));
    const FlatBox bounds = bounds_of(set.layers);
    const double farthest = static_cast<double>(farthest_of(bounds)) * grid_mm_;
    require(check_reach(grown, grid_mm_, farthest));
    widen_box(set.layers, bounds, moved_mm(grown));
    if (const SliceResult* const stack = set.layers.stack()) {
        stack_ = stack_ == nullptr ? stack : stack_;
        check_planes(*stack);
    }
    return farthest + moved_mm(grown);
}

/// Planes are the same where they were asked for at one height: in a mesh of floats they are cut at the nearest float.
void LayerSets::check_planes(const SliceResult& own) const {
    if (own.size() != stack_->size()) {
        throw bad_set("it has " + std::to_string(own.size()) + " layers, and another set " + std::to_string(stack_->size()));
    }
    for (std::size_t n = 0; n < own.size(); ++n) {
        const Layer& layer = own.layers[n];
        const Layer& other = stack_->layers[n];
        if (layer.plane != other.plane && layer.plane_mm != other.plane_mm) {
            throw bad_set("its layer " + std::to_string(n) + " lies at " + exact_text(own[n].cut_mm()) +
                          " mm, and another set's at " + exact_text((*stack_)[n].cut_mm()) + " mm");
        }
    }
}

/// Throws Refused where a point lies beyond the grid.
FlatBox LayerSets::bounds_of(const Layers& layers) const {
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
void LayerSets::widen_box(const Layers& layers, const FlatBox& points, double moved_mm) {
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
        const double grid = grid_mm_;
        const double out = moved_mm > 0 || layers.stack() == nullptr ? moved_mm : -2 * grid;
        Box box = box_.value_or(Box{});
        box.min_mm = {points.low.x * grid - out, points.low.y * grid - out, box.min_mm[2]};
        box.max_mm = {points.high.x * grid + out, points.high.y * grid + out, box.max_mm[2]};
        include(box);
    }
}

SliceInfo LayerSets::begin_info(const RegionRules& after, double moved_mm) const {
    SliceInfo info;
    if (stack_ != nullptr) {
        const SliceInfo& of = stack_->info;
        info.first_layer = of.first_layer;
        info.planned_layers = of.planned_layers;
        info.layer_of = of.layer_of;
        info.options = of.options;
    }
    info.box = box_.value_or(Box{});
    for (std::size_t axis = 0; axis < 2; ++axis) {
        info.box.min_mm[axis] -= moved_mm;
        info.box.max_mm[axis] += moved_mm;
    }
    info.options.region = after;
    info.options.origins = false;
    info.options.unite_parts = false;
    info.grid_mm = grid_mm_;
    info.layers = stack_ == nullptr ? 1 : stack_->size();
    for (const LayerSet& set : sets_) {
        info.segments += set.layers.stack() != nullptr ? set.layers.stack()->info.segments : 0;
    }
    return info;
}

Layer LayerSets::describe(PlaneIndex n) const {
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

std::vector<Band> LayerSets::cut_tasks(std::uint64_t layers, const Parallel& parallel) const {
    constexpr std::uint64_t most_layers = 16;
    constexpr std::uint64_t enough_points = 1 << 14;
    std::vector<Band> tasks;
    std::uint64_t points = 0;
    for (PlaneIndex n = 0; n < layers; ++n) {
        if (tasks.empty() || points >= enough_points || n - tasks.back().first >= most_layers) {
            parallel.stop_if_asked();
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

}  // namespace lamella
