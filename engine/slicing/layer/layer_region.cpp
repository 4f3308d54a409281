#include "slicing/layer/layer_region.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/numbers.hpp"

namespace lamella {

namespace {

/// Takes the points that lie between their neighbours off a closed contour that has an area, in place; returns how many are
/// left. An edge that several become has the origin of the first of them, or of the last where the contour will be turned
/// round. `origins`: of the edges, or null. O(points).
std::size_t drop_collinear(std::span<Point> ring, PointOrigin* origins, bool will_turn) noexcept {
    const auto is_between = [ring](std::size_t before, std::size_t at, std::size_t after) {
        return side_of(ring[before], ring[at], ring[after]) == 0;
    };
    const auto move = [=](std::size_t from, std::size_t to) {
        ring[to] = ring[from];
        if (origins != nullptr) {
            origins[to] = origins[from];
        }
    };
    const auto merge = [=](std::size_t into, std::size_t next) {
        if (origins != nullptr) {
            origins[into] = stretch_of(origins[will_turn ? next : into], !will_turn, will_turn);
        }
    };
    std::size_t left = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        while (left >= 2 && is_between(left - 2, left - 1, i)) {
            --left;
            merge(left - 1, left);
        }
        move(i, left++);
    }
    while (left > 3 && is_between(left - 2, left - 1, 0)) {
        --left;
        merge(left - 1, left);
    }
    std::size_t first = 0;
    while (left - first > 3 && is_between(left - 1, first, first + 1)) {
        merge(left - 1, first++);
    }
    for (std::size_t i = first; i < left && first > 0; ++i) {
        move(i, i - first);
    }
    return left - first;
}

}  // namespace

bool LayerRegion::apply(const RegionRules& rules, FillRule fill, double grid_mm) {
    rules_ = &rules;
    grid_mm_ = grid_mm;
    if (fill != FillRule::contours) {
        replace_closed(fill);
    }
    if (rules.simplify_mm > 0) {
        simplify();
    }
    if (fill == FillRule::contours) {
        layer_.nester.nest(layer_.items);
    }
    mark_near();
    return fill != FillRule::contours && regions_.cancels();
}

void LayerRegion::take(const Fill& region, const RegionRules& rules, double grid_mm) {
    rules_ = &rules;
    grid_mm_ = grid_mm;
    layer_.paths.clear();
    regions_.go_on(region, steps(), layer_.nester);
    take_paths(false);
    if (rules.simplify_mm > 0) {
        simplify();
    }
    mark_near();
}

void LayerRegion::replace_closed(FillRule fill) {
    closed_.clear();
    for (std::size_t i = 0; i < layer_.items.size(); ++i) {
        if (layer_.items[i].closed) {
            closed_.push_back(layer_.path_of(i));
        }
    }
    RegionSteps steps = this->steps();
    steps.rule = fill;
    steps.always_list = rules_->drop_collinear || rules_->largest_only || fill == FillRule::outermost ||
                        closed_.size() != layer_.items.size();
    regions_.run(closed_, steps, layer_.nester);
    if (regions_.is_unchanged() && regions_.paths().empty()) {
        std::copy(regions_.nested().begin(), regions_.nested().end(), layer_.items.begin());
        return;
    }
    take_paths(fill == FillRule::outermost);
}

/// In place of the layer's closed ones.
void LayerRegion::take_paths(bool outermost) {
    std::erase_if(layer_.paths, [](const Path& path) { return path.item.closed; });
    const auto polylines = static_cast<std::int64_t>(layer_.paths.size());
    for (const Path& path : regions_.paths()) {
        layer_.paths.push_back(path);
        layer_.paths.back().touched += path.touched < 0 ? 0 : polylines;
    }
    rewrite_paths();
    layer_.sort_by_start();
    nest_region();
    if (rules_->largest_only || outermost) {
        keep_some(outermost, rules_->largest_only);
        layer_.sort_by_start();
        nest_region();
    }
}

void LayerRegion::mark_near() {
    if (rules_->flag_closing_mm > 0) {
        regions_.mark_near(layer_.items, rules_->flag_closing_mm / grid_mm_, rules_->miter_limit, layer_.nester);
    }
}

/// Those that were made, or may lose points, get points of their own.
void LayerRegion::rewrite_paths() {
    std::size_t points = 0;
    for (const Path& path : layer_.paths) {
        points += is_rewritten(path) ? path.item.count : 0;
    }
    made_.resize(points);
    made_origins_.resize(layer_.with_origins ? points : 0);
    std::span<Point> rest(made_);
    for (Path& path : layer_.paths) {
        layer_.worker.spend(LayerContours::contour_work + path.item.count);
        if (is_rewritten(path)) {
            const std::span<Point> own = rest.first(path.item.count);
            rest = rest.subspan(own.size());
            rewrite(path, own, layer_.with_origins ? made_origins_.data() + (own.data() - made_.data()) : nullptr);
        }
    }
}

/// To these points, and origins unless null.
void LayerRegion::rewrite(Path& path, std::span<Point> points, PointOrigin* origins) const {
    const NestItem before = path.item;
    std::copy_n(before.points, before.count, points.data());
    if (origins != nullptr && before.origins != nullptr) {
        std::copy_n(before.origins, before.count, origins);
    } else if (origins != nullptr) {
        std::fill_n(origins, before.count, PointOrigin());
    }
    const bool will_turn = (to_int128(before.twice_area) > 0) == path.hole;
    const std::size_t left = rules_->drop_collinear ? drop_collinear(points, origins, will_turn) : points.size();
    const Path rewritten = closed_path(points.first(left), origins);
    path.item = rewritten.item;
    path.item.flags = before.flags;
    path.item.part = before.part;
    if (path.made) {
        path.start_key = rewritten.start_key;
        path.segments = rewritten.segments;
    }
}

bool LayerRegion::is_rewritten(const Path& path) const noexcept {
    return path.item.closed && (path.made || rules_->drop_collinear);
}

/// Parents and roles of a region's contours. Those that were made may touch in points, so that a start may lie on what
/// encloses it, and nesting finds something larger. Only an outer one can: a hole touches nothing that its own piece of
/// solid ends at, since it would be part of it. What it touches at its start then says where it lies, as nothing solid is
/// between them: within a hole, or beside an outer one that has the same parent.
void LayerRegion::nest_region() {
    item_of_.resize(layer_.paths.size());
    for (std::uint32_t i = 0; i < layer_.items.size(); ++i) {
        item_of_[layer_.order.path_of(i)] = i;
    }
    layer_.nester.nest(layer_.items);
    for (std::uint32_t i = 0; i < layer_.items.size(); ++i) {
        NestItem& item = layer_.items[i];
        if (item.orientation == 0) {
            continue;
        }
        const bool hole = layer_.path_of(i).hole;
        item.reverse = hole == (item.orientation > 0);
        item.orientation = static_cast<std::int8_t>(hole ? -1 : 1);  // as stored, whatever the facets say
        item.role = hole ? Role::hole : Role::outer;
        item.flags &= static_cast<std::uint16_t>(~orientation_overruled);
    }
    is_settled_.assign(layer_.items.size(), 0);
    // A touched path starts before, or at the same point: the way to one that is settled is short.
    for (std::uint32_t i = 0; i < layer_.items.size(); ++i) {
        std::uint32_t at = i;
        while (is_settled_[at] == 0 && layer_.items[at].role == Role::outer && layer_.path_of(at).touched >= 0) {
            at = item_of_[static_cast<std::size_t>(layer_.path_of(at).touched)];
        }
        if (at != i) {
            layer_.items[i].parent =
                layer_.items[at].role == Role::hole ? static_cast<std::int32_t>(at) : layer_.items[at].parent;
        }
        is_settled_[i] = 1;
    }
    assert(std::all_of(layer_.items.begin(), layer_.items.end(), [this](const NestItem& item) {
        const Role around = item.parent < 0 ? Role::hole : layer_.items[static_cast<std::size_t>(item.parent)].role;
        return item.orientation == 0 || (around == Role::hole) == (item.role == Role::outer);
    }));
}

/// Keeps only those of the region that lie in no other, or only the largest of these with its holes.
void LayerRegion::keep_some(bool outermost, bool largest) {
    std::int32_t first = -1;
    for (std::size_t i = 0; i < layer_.items.size() && largest; ++i) {
        const bool is_larger =
            layer_.items[i].role == Role::outer &&
            (first < 0 || size_of(layer_.items[i]) > size_of(layer_.items[static_cast<std::size_t>(first)]));
        first = is_larger ? static_cast<std::int32_t>(i) : first;
    }
    kept_.clear();
    for (std::size_t i = 0; i < layer_.items.size(); ++i) {
        const NestItem& item = layer_.items[i];
        const bool in_largest = static_cast<std::int32_t>(i) == first || (item.role == Role::hole && item.parent == first);
        if (!item.closed || ((!outermost || item.parent < 0) && (!largest || in_largest))) {
            kept_.push_back(layer_.path_of(i));
            kept_.back().touched = -1;  // holes and what lies in them have gone
        }
    }
    layer_.paths.swap(kept_);
}

/// A region keeps its parents and roles: no contour of it crosses another, before or after.
void LayerRegion::simplify() {
    const double units = std::floor(rules_->simplify_mm / grid_mm_);
    constexpr double most = 2.0 * grid_limit;
    simplifier_.run(layer_.items, static_cast<std::int64_t>(std::min(units, most)));
    for (std::size_t i = 0; i < layer_.items.size(); ++i) {
        Path& path = layer_.path_of(i);
        path.segments = path.made ? layer_.items[i].count : path.segments;
    }
}

}  // namespace lamella
