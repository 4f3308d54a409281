// The calls of lamella.h that combine layers with layers.
#include <algorithm>
#include <deque>
#include <new>
#include <string>
#include <vector>

#include "c/call.hpp"

namespace lamella::c {

namespace {

/// The program's sets. Holds what the C++ sets view: neither copied nor moved.
class GivenSets {
public:
    /// `first`: the number of the first in messages.
    GivenSets(const lamella_layer_set* given, std::size_t count, std::size_t first = 0) {
        require_list(given, count, "sets");
        if (count > most_layer_sets) {
            refuse("from 1 to " + std::to_string(most_layer_sets) + " sets of layers can be combined, not " +
                   std::to_string(count));
        }
        const auto* at = reinterpret_cast<const unsigned char*>(given);
        const std::uint32_t step = size_given(given, Sized<lamella_layer_set>::name, Sized<lamella_layer_set>::init);
        for (std::size_t s = 0; s < count; ++s, at += step) {
            const auto* const set = reinterpret_cast<const lamella_layer_set*>(at);
            if (size_given(set, Sized<lamella_layer_set>::name, Sized<lamella_layer_set>::init) != step) {
                refuse("the sets do not begin with one size: initialise each by LAMELLA_INIT(&it, LAMELLA_LAYER_SET)");
            }
            sets_.push_back(read(read_sized(set), "set " + std::to_string(first + s) + ": "));
        }
    }
    GivenSets(const GivenSets&) = delete;
    GivenSets& operator=(const GivenSets&) = delete;

    std::span<const LayerSet> sets() const noexcept { return sets_; }

private:
    LayerSet read(const lamella_layer_set& c, const std::string& name) {
        require_choice(c.fill_rule, LAMELLA_FILL_RULE_OUTERMOST, (name + "fill_rule").c_str());
        LayerSet set{.layers = layers_of(c, name),
                     .from = c.from,
                     .to = c.to,
                     .grow_mm = c.grow_mm,
                     .fill_rule = static_cast<FillRule>(c.fill_rule)};
        if (c.part < -1 || c.part > several_parts) {
            refuse(name + "part is " + std::to_string(c.part) + ", but parts are -1, for all, to " +
                   std::to_string(several_parts));
        }
        if (c.part >= 0) {
            set.part = static_cast<std::uint32_t>(c.part);
        }
        return set;
    }

    Layers layers_of(const lamella_layer_set& c, const std::string& name) {
        if (c.result != nullptr && c.contours != nullptr) {
            refuse(name + "of result and contours one can be set, and both are");
        }
        if (c.result == nullptr) {
            if (c.contours == nullptr && c.contour_count == 0) {
                return {};
            }
            paths_.push_back(read_paths(c.contours, c.contour_count));
            return contours_.emplace_back(ContourSet{paths_.back(), c.contour_grid_mm});
        }
        const SliceResult& stack = c.result->result;
        if (c.layer == -1) {
            return stack;
        }
        if (c.layer < 0 || static_cast<std::uint64_t>(c.layer) >= stack.size()) {
            refuse(name + "the result has no layer " + std::to_string(c.layer));
        }
        return layers_.emplace_back(stack[static_cast<std::size_t>(c.layer)]);
    }

    std::deque<std::vector<std::span<const Point>>> paths_;
    std::deque<ContourSet> contours_;
    std::deque<LayerView> layers_;
    std::vector<LayerSet> sets_;
};

/// Refers to `c`.
Rule rule_of(const lamella_rule& c) {
    require_list(c.labels, c.label_count, "labels");
    if (c.labels != nullptr && c.label_count == 0) {
        refuse("labels is set, but its count is 0");
    }
    Rule rule{.any = c.any,
              .all = c.all,
              .none = c.none,
              .not_all = c.not_all,
              .odd = c.odd != 0,
              .last_wins = c.last_wins != 0,
              .labels = {c.labels, c.label_count}};
    if (c.label_of != nullptr) {
        rule.label_of = {const_cast<lamella_rule*>(&c), [](void* self, std::uint64_t inside) noexcept {
                             const auto& given = *static_cast<const lamella_rule*>(self);
                             return given.label_of(given.label_object, inside);
                         }};
    }
    return rule;
}

std::vector<OffsetStep> read_steps(const lamella_offset_step* given, std::size_t count) {
    require_list(given, count, "steps");
    std::vector<OffsetStep> steps;
    for (std::size_t i = 0; i < std::min<std::size_t>(count, most_labels + 1); ++i) {
        if (given[i].reserved != 0) {
            refuse("step " + std::to_string(i) + ": reserved must be 0");
        }
        steps.push_back({given[i].mm, given[i].drop == 0});
    }
    return steps;
}

OffsetOptions read_offset(const lamella_offset* given) {
    const lamella_offset c = read_sized(given);
    require_choice(c.join, LAMELLA_JOIN_SQUARE, "join");
    require_choice(c.end, LAMELLA_END_ROUND, "end");
    return {.join = static_cast<Join>(c.join),
            .end = static_cast<End>(c.end),
            .miter_limit = c.miter_limit,
            .arc_tolerance_mm = c.arc_tolerance_mm};
}

}  // namespace

void set_defaults(lamella_offset& offset) noexcept {
    const OffsetOptions options;
    offset.miter_limit = options.miter_limit;
    offset.arc_tolerance_mm = options.arc_tolerance_mm;
}

void set_defaults(lamella_layer_set& set) noexcept {
    set.fill_rule = LAMELLA_FILL_RULE_NON_ZERO;
    set.layer = -1;
    set.contour_grid_mm = default_grid_mm;
    set.part = -1;
}

void set_defaults(lamella_rule& rule) noexcept {
    rule.any = unite.any;
}

}  // namespace lamella::c

namespace api = lamella::c;

lamella_overlay* lamella_overlay_create(void) {
    return new (std::nothrow) lamella_overlay;
}

void lamella_overlay_reset(lamella_overlay* overlay) {
    if (overlay != nullptr) {
        overlay->overlay.reset();
    }
}

void lamella_overlay_free(lamella_overlay* overlay) {
    delete overlay;
}

int32_t lamella_overlay_combine(lamella_overlay* overlay, const lamella_destination* to, const lamella_layer_set* sets,
                                size_t set_count, const lamella_rule* rule, const lamella_options* after,
                                const lamella_context* context, lamella_info* info, lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        const lamella_destination where = api::read_destination(to);
        api::Kept<lamella_overlay> kept(overlay);
        const api::Host host(context);
        lamella::SliceOptions how;
        api::read_options(after, how);
        const api::GivenSets given(sets, set_count);
        const lamella_rule by = api::read_sized(rule);
        api::fill_destination(where, [&](const lamella::Destination& place, const lamella::SliceResult* result) {
            kept.give(kept->overlay.combine(place, given.sets(), api::rule_of(by), how.region, host.context), info, result);
        });
    });
}

int32_t lamella_overlay_offset(lamella_overlay* overlay, const lamella_destination* to, const lamella_layer_set* of,
                               const lamella_offset_step* steps, size_t step_count, const lamella_offset* offset,
                               const lamella_options* after, const lamella_context* context, lamella_info* info,
                               lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        const lamella_destination where = api::read_destination(to);
        api::Kept<lamella_overlay> kept(overlay);
        const api::Host host(context);
        lamella::SliceOptions how;
        api::read_options(after, how);
        const api::GivenSets given(of, 1);
        const std::vector<lamella::OffsetStep> moves = api::read_steps(steps, step_count);
        const lamella::OffsetOptions options = api::read_offset(offset);
        api::fill_destination(where, [&](const lamella::Destination& place, const lamella::SliceResult* result) {
            kept.give(kept->overlay.offset(place, given.sets()[0], moves, options, how.region, host.context), info, result);
        });
    });
}

int32_t lamella_overlay_clip(lamella_overlay* overlay, const lamella_destination* to, const lamella_layer_set* lines,
                             const lamella_layer_set* by, int32_t keep, const lamella_context* context, lamella_info* info,
                             lamella_error* error) {
    return api::called(error, [&] {
        api::require_initialised(info);
        const lamella_destination where = api::read_destination(to);
        api::Kept<lamella_overlay> kept(overlay);
        const api::Host host(context);
        api::require_choice(keep, LAMELLA_CLIP_OUTSIDE | LAMELLA_CLIP_BOUNDARY_IS_OUTSIDE, "keep");
        const api::GivenSets polylines(lines, 1);
        const api::GivenSets region(by, 1, 1);
        const lamella::LayerSet& own = polylines.sets()[0];
        if (own.from != 0 || own.to != 0 || own.grow_mm != 0 || own.part) {
            api::refuse("set 0: polylines are clipped as they are, but of lines from, to, grow_mm or part is set");
        }
        const lamella::ClipOptions options{.inside = (keep & LAMELLA_CLIP_OUTSIDE) == 0,
                                           .boundary_is_inside = (keep & LAMELLA_CLIP_BOUNDARY_IS_OUTSIDE) == 0};
        api::fill_destination(where, [&](const lamella::Destination& place, const lamella::SliceResult* result) {
            kept.give(kept->overlay.clip(place, own.layers, region.sets()[0], options, host.context), info, result);
        });
    });
}
