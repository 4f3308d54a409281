#include "slicing/layer/layer_builder.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/clock.hpp"
#include "base/numbers.hpp"
#include "slicing/nesting/nest.hpp"
#include "slicing/regions/regions.hpp"

namespace lamella {

namespace {

constexpr std::size_t contour_work = 32;  ///< as StopPace counts it

bool is_closed(const Path& path) noexcept {
    return path.item.closed;
}

}  // namespace

void LayerBuilder::build(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, BandOutput& out) {
    rings_.read(graph, points, origins, paths_);
    finish(out);
}

void LayerBuilder::build_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                                const Parallel& parallel, BandOutput& out) {
    read_traced(rings, origins, walked, key_at, parallel, paths_);
    finish(out);
}

void LayerBuilder::build_given(std::span<const Path> contours, BandOutput& out) {
    given_.clear();
    given_origins_.clear();
    for (const Path& given : contours) {
        const NestItem& item = given.item;
        given_.insert(given_.end(), item.points, item.points + item.count);
        given_origins_.insert(given_origins_.end(), item.origins, item.origins + (item.origins != nullptr ? item.count : 0));
        worker_.spend(item.count);
    }
    paths_.clear();
    std::span<Point> rest(given_);
    for (const Path& given : contours) {
        const NestItem& item = given.item;
        const std::span<Point> points = rest.first(item.count);
        rest = rest.subspan(item.count);
        PointOrigin* const origins =
            given_origins_.empty() ? nullptr : given_origins_.data() + (points.data() - given_.data());
        if (item.reverse) {
            turn_round(points, origins, item.closed);
        }
        Path& path = paths_.emplace_back(item.closed ? closed_path(points, origins) : open_path(points, origins));
        path.segments = given.segments;
        path.item.flags = item.flags;
        path.item.part = item.part;
    }
    finish(out);
}

void LayerBuilder::finish(BandOutput& out) {
    with_origins_ = out.with_origins;
    if (rules.stitch > 0) {
        close_gaps(out);
    }
    sort_by_start();
    const std::uint64_t before = timed ? ticks() : 0;
    const std::uint64_t filled_before = fill_ticks;
    const std::uint64_t layer = rules.first_layer + out.first_layer + out.layer_contours.size();
    cancels_ = false;
    nest(rules.region == nullptr ? FillRule::contours : rules.region->rule_of(layer));
    nesting_ticks += timed ? ticks() - before - (fill_ticks - filled_before) : 0;
    order_.put_holes_after_outers(items_);
    out.counts.cancelled_layers += cancels_ ? 1 : 0;
    append(out);
}

/// Replaces the open contours by what they are joined to.
void LayerBuilder::close_gaps(BandOutput& out) {
    const auto first_open = std::stable_partition(paths_.begin(), paths_.end(), is_closed);
    const auto closed = std::span(paths_).first(static_cast<std::size_t>(first_open - paths_.begin()));
    if (repair_.join(std::span(paths_).subspan(closed.size()), closed,
                     {rules.stitch, rules.crossing_stitch, rules.direction}, out.layer_contours.size(), out.stitches)) {
        paths_.erase(first_open, paths_.end());
        paths_.insert(paths_.end(), repair_.joined().begin(), repair_.joined().end());
    }
}

void LayerBuilder::sort_by_start() {
    order_.sort_by_start(paths_);
    items_.clear();
    reserve_more(items_, paths_.size());
    for (std::size_t i = 0; i < paths_.size(); ++i) {
        worker_.spend(contour_work);
        items_.push_back(path_of(i).item);
    }
}

void LayerBuilder::nest(FillRule rule) {
    const bool marks = rules.region != nullptr && rules.region->flag_closing_mm > 0;
    const bool simplifies = rules.region != nullptr && rules.region->simplify_mm > 0;
    const std::uint64_t before = timed ? ticks() : 0;
    if (rule != FillRule::contours) {
        apply_rules(rule);
    }
    if (simplifies) {
        simplify();
    }
    if (rule == FillRule::contours) {
        nester_.nest(items_);
    }
    if (marks) {
        regions_.mark_near(items_, rules.region->flag_closing_mm / rules.grid_mm, rules.region->miter_limit, nester_);
    }
    fill_ticks += timed && (marks || simplifies || rule != FillRule::contours) ? ticks() - before : 0;
}

/// A region keeps its parents and roles: no contour of it crosses another, before or after.
void LayerBuilder::simplify() {
    const double units = std::floor(rules.region->simplify_mm / rules.grid_mm);
    constexpr double most = 2.0 * grid_limit;
    simplifier_.run(items_, static_cast<std::int64_t>(std::min(units, most)));
    for (std::size_t i = 0; i < items_.size(); ++i) {
        Path& path = paths_[order_.path_of(i)];
        path.segments = path.made ? items_[i].count : path.segments;
    }
}

void LayerBuilder::apply_rules(FillRule rule) {
    const RegionRules& region = *rules.region;
    const bool rewrites = region.drop_collinear || region.largest_only || rule == FillRule::outermost;
    closed_.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        if (items_[i].closed) {
            closed_.push_back(path_of(i));
        }
    }
    regions_.run(closed_,
                 {.rule = rule,
                  .close = region.closing_mm / rules.grid_mm,
                  .offset = region.offset_mm / rules.grid_mm,
                  .miter = region.miter_limit,
                  .always_list = rewrites || closed_.size() != items_.size()},
                 nester_);
    cancels_ = regions_.cancels();
    if (regions_.is_unchanged() && regions_.paths().empty()) {
        std::copy(regions_.nested().begin(), regions_.nested().end(), items_.begin());
        return;
    }
    std::erase_if(paths_, is_closed);
    const auto polylines = static_cast<std::int64_t>(paths_.size());
    for (const Path& path : regions_.paths()) {
        paths_.push_back(path);
        paths_.back().touched += path.touched < 0 ? 0 : polylines;
    }
    rewrite_paths();
    sort_by_start();
    nest_region();
    if (region.largest_only || rule == FillRule::outermost) {
        keep_some(rule == FillRule::outermost, region.largest_only);
        sort_by_start();
        nest_region();
    }
}

/// Those that were made, or may lose points, get points of their own.
void LayerBuilder::rewrite_paths() {
    std::size_t points = 0;
    for (const Path& path : paths_) {
        points += is_rewritten(path) ? path.item.count : 0;
    }
    made_.resize(points);
    made_origins_.resize(with_origins_ ? points : 0);
    std::span<Point> rest(made_);
    for (Path& path : paths_) {
        worker_.spend(contour_work + path.item.count);
        if (is_rewritten(path)) {
            const std::span<Point> own = rest.first(path.item.count);
            rest = rest.subspan(own.size());
            rewrite(path, own, with_origins_ ? made_origins_.data() + (own.data() - made_.data()) : nullptr);
        }
    }
}

/// To these points, and origins unless null.
void LayerBuilder::rewrite(Path& path, std::span<Point> points, PointOrigin* origins) const {
    const NestItem before = path.item;
    std::copy_n(before.points, before.count, points.data());
    if (origins != nullptr && before.origins != nullptr) {
        std::copy_n(before.origins, before.count, origins);
    } else if (origins != nullptr) {
        std::fill_n(origins, before.count, PointOrigin());
    }
    const bool will_turn = (to_int128(before.twice_area) > 0) == path.hole;
    const std::size_t left = rules.region->drop_collinear ? drop_collinear(points, origins, will_turn) : points.size();
    const Path rewritten = closed_path(points.first(left), origins);
    path.item = rewritten.item;
    path.item.flags = before.flags;
    path.item.part = before.part;
    if (path.made) {
        path.start_key = rewritten.start_key;
        path.segments = rewritten.segments;
    }
}

bool LayerBuilder::is_rewritten(const Path& path) const noexcept {
    return path.item.closed && (path.made || rules.region->drop_collinear);
}

/// Parents and roles of a region's contours. Those that were made may touch in points, so that a start may lie on what
/// encloses it, and nesting finds something larger. Only an outer one can: a hole touches nothing that its own piece of
/// solid ends at, since it would be part of it. What it touches at its start then says where it lies, as nothing solid is
/// between them: within a hole, or beside an outer one that has the same parent.
void LayerBuilder::nest_region() {
    item_of_.resize(paths_.size());
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        item_of_[order_.path_of(i)] = i;
    }
    nester_.nest(items_);
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        NestItem& item = items_[i];
        if (item.orientation == 0) {
            continue;
        }
        const bool hole = path_of(i).hole;
        item.reverse = hole == (item.orientation > 0);
        item.orientation = static_cast<std::int8_t>(hole ? -1 : 1);  // as stored, whatever the facets say
        item.role = hole ? Role::hole : Role::outer;
        item.flags &= static_cast<std::uint16_t>(~orientation_overruled);
    }
    is_settled_.assign(items_.size(), 0);
    // A touched path starts before, or at the same point: the way to one that is settled is short.
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        std::uint32_t at = i;
        while (is_settled_[at] == 0 && items_[at].role == Role::outer && path_of(at).touched >= 0) {
            at = item_of_[static_cast<std::size_t>(path_of(at).touched)];
        }
        if (at != i) {
            items_[i].parent = items_[at].role == Role::hole ? static_cast<std::int32_t>(at) : items_[at].parent;
        }
        is_settled_[i] = 1;
    }
    assert(std::all_of(items_.begin(), items_.end(), [this](const NestItem& item) {
        const Role around = item.parent < 0 ? Role::hole : items_[static_cast<std::size_t>(item.parent)].role;
        return item.orientation == 0 || (around == Role::hole) == (item.role == Role::outer);
    }));
}

/// Keeps only those of the region that lie in no other, or only the largest of these with its holes.
void LayerBuilder::keep_some(bool outermost, bool largest) {
    std::int32_t first = -1;
    for (std::size_t i = 0; i < items_.size() && largest; ++i) {
        const bool is_larger = items_[i].role == Role::outer &&
                               (first < 0 || size_of(items_[i]) > size_of(items_[static_cast<std::size_t>(first)]));
        first = is_larger ? static_cast<std::int32_t>(i) : first;
    }
    kept_.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const NestItem& item = items_[i];
        const bool in_largest = static_cast<std::int32_t>(i) == first || (item.role == Role::hole && item.parent == first);
        if (!item.closed || ((!outermost || item.parent < 0) && (!largest || in_largest))) {
            kept_.push_back(path_of(i));
            kept_.back().touched = -1;  // holes and what lies in them have gone
        }
    }
    paths_.swap(kept_);
}

/// From element `first` on.
template <class T>
void LayerBuilder::copy_rotated(const T* from, std::size_t first, std::size_t count, T* to) {
    worker_.in_stretches(first, count, 1, [&](std::size_t begin, std::size_t end) {
        std::copy(from + begin, from + end, to + (begin - first));
    });
    to += count - first;
    worker_.in_stretches(0, first, 1,
                         [&](std::size_t begin, std::size_t end) { std::copy(from + begin, from + end, to + begin); });
}

void LayerBuilder::append(BandOutput& out) {
    const std::size_t base = out.contours.size();
    for (const std::uint32_t i : order_.items()) {
        const NestItem& item = items_[i];
        worker_.spend(contour_work);
        const std::size_t first = item.reverse ? item.start + 1 : item.start;  // the start comes last to be turned round
        Point* const points = out.reserve_points(item.count);
        copy_rotated(item.points, first, item.count, points);
        PointOrigin* const origins = out.with_origins ? out.origins + out.point_count : nullptr;
        if (origins != nullptr) {
            copy_rotated(item.origins, first, item.count, origins);
        }
        if (item.reverse) {
            turn_round({points, item.count}, origins, item.closed);
        }
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.twice_area = item.reverse ? to_integer128(-to_int128(item.twice_area)) : item.twice_area;
        contour.parent =
            item.parent < 0 ? -1 : static_cast<std::int64_t>(base + order_.place_of(static_cast<std::size_t>(item.parent)));
        contour.point_count = item.count;
        contour.segments = path_of(i).segments;
        contour.role = item.role;
        contour.orientation = item.orientation;
        contour.flags = item.flags;
        contour.part = item.part;
        out.counts.add(contour);
        out.point_count += item.count;
    }
    out.layer_contours.push_back(static_cast<std::uint32_t>(items_.size()));
}

}  // namespace lamella
