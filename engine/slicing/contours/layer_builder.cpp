#include "slicing/contours/layer_builder.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/clock.hpp"
#include "base/numbers.hpp"
#include "slicing/grid/origins.hpp"
#include "slicing/regions/collinear.hpp"

namespace lamella {

namespace {

constexpr std::size_t contour_work = 32;  ///< as StopPace counts it

bool is_closed(const LayerContour& contour) noexcept {
    return contour.item.closed;
}

Int128 size_of(const NestItem& item) noexcept {
    const Int128 area = to_int128(item.twice_area);
    return area < 0 ? -area : area;
}

}  // namespace

LayerBuilder::LayerBuilder(const Memory* memory)
    : rings_(memory),
      repair_(memory),
      order_(memory),
      nester_(memory),
      regions_(memory),
      region_nesting_(memory),
      simplifier_(memory),
      contours_(memory),
      items_(memory),
      polylines_(memory),
      around_(memory),
      walked_(memory),
      closed_(memory),
      walked_of_(memory),
      ring_of_(memory),
      region_(memory),
      kept_(memory),
      made_(memory),
      made_origins_(memory),
      given_(memory),
      given_origins_(memory) {}

void LayerBuilder::follow(const StopCheck& host) noexcept {
    pace_.follow(host);
    rings_.follow(host);
    order_.follow(host);
    repair_.follow(host);
    nester_.follow(host);
    regions_.follow(host);
    simplifier_.follow(host);
}

void LayerBuilder::build(const LinkGraph& graph, const Point* points, const SlotOrigins* origins, BandOutput& out) {
    rings_.read(graph, points, origins, contours_);
    finish(out);
}

void LayerBuilder::build_traced(Point* rings, PointOrigin* origins, std::span<const WalkedContour> walked, KeyAt key_at,
                                const Parallel& parallel, BandOutput& out) {
    read_traced(rings, origins, walked, key_at, parallel, contours_);
    finish(out);
}

void LayerBuilder::build_given(std::span<const GivenContour> contours, BandOutput& out) {
    given_.clear();
    given_origins_.clear();
    for (const GivenContour& contour : contours) {
        given_.insert(given_.end(), contour.points.begin(), contour.points.end());
        given_origins_.insert(given_origins_.end(), contour.origins.begin(), contour.origins.end());
        pace_.spend(contour.points.size());
    }
    contours_.clear();
    std::span<Point> rest(given_);
    for (const GivenContour& given : contours) {
        const std::span<Point> points = rest.first(given.points.size());
        rest = rest.subspan(given.points.size());
        PointOrigin* const origins =
            given_origins_.empty() ? nullptr : given_origins_.data() + (points.data() - given_.data());
        if (given.turned) {
            std::reverse(points.begin(), points.end());
            for (std::size_t i = 0; i < given.origins.size(); ++i) {
                origins[i] = origin_turned_round(given.origins, i);
            }
        }
        LayerContour& contour =
            contours_.emplace_back(given.closed ? closed_contour(points, origins) : open_contour(points, origins));
        contour.segments = given.segments;
        contour.item.flags = given.flags;
        contour.item.part = given.part;
    }
    finish(out);
}

void LayerBuilder::finish(BandOutput& out) {
    with_origins_ = out.with_origins;
    if (rules.close_gaps > 0) {
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
    const auto first_open = std::stable_partition(contours_.begin(), contours_.end(), is_closed);
    polylines_.clear();
    std::transform(first_open, contours_.end(), std::back_inserter(polylines_), [](const LayerContour& open) {
        return Polyline{
            {open.item.points, open.item.count}, open.item.origins, open.start_key, open.segments, open.item.flags};
    });
    around_.clear();
    std::transform(contours_.begin(), first_open, std::back_inserter(around_),
                   [](const LayerContour& closed) { return std::span<const Point>(closed.item.points, closed.item.count); });
    if (!repair_.join(polylines_, around_, {rules.close_gaps, rules.crossing_gaps, rules.gap_sense},
                      out.layer_contours.size(), out.closed_gaps)) {
        return;
    }
    contours_.erase(first_open, contours_.end());
    for (const JoinedPolyline& joined : repair_.joined()) {
        LayerContour& contour = contours_.emplace_back(joined.closed ? closed_contour(joined.points, joined.origins)
                                                                     : open_contour(joined.points, joined.origins));
        contour.start_key = joined.closed ? EndKey{} : joined.start_key;
        contour.segments = joined.segments;
        contour.item.flags = joined.flags;
    }
}

void LayerBuilder::sort_by_start() {
    order_.sort_by_start(contours_);
    items_.clear();
    reserve_more(items_, contours_.size());
    for (std::size_t i = 0; i < contours_.size(); ++i) {
        pace_.spend(contour_work);
        items_.push_back(contours_[order_.contour_of(i)].item);
    }
}

void LayerBuilder::nest(FillRule rule) {
    const bool marks = rules.region != nullptr && rules.region->mark_near_mm > 0;
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
        regions_.mark_near(items_, rules.region->mark_near_mm / rules.unit_mm, rules.region->miter_limit, nester_);
    }
    fill_ticks += timed && (marks || simplifies || rule != FillRule::contours) ? ticks() - before : 0;
}

/// A region keeps its parents and roles: no contour of it crosses another, before or after.
void LayerBuilder::simplify() {
    const double units = std::floor(rules.region->simplify_mm / rules.unit_mm);
    constexpr double most = 2.0 * grid_limit;
    simplifier_.run(items_, static_cast<std::int64_t>(std::min(units, most)));
    for (std::size_t i = 0; i < items_.size(); ++i) {
        LayerContour& contour = contours_[order_.contour_of(i)];
        contour.segments = contour.made ? items_[i].count : contour.segments;
    }
}

void LayerBuilder::apply_rules(FillRule rule) {
    const RegionRules& region = *rules.region;
    const bool rewrites = region.drop_collinear || region.largest_only || rule == FillRule::outermost;
    closed_.clear();
    walked_of_.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        if (items_[i].closed) {
            closed_.push_back(items_[i]);
            walked_of_.push_back(order_.contour_of(i));
        }
    }
    regions_.run(closed_,
                 {.rule = rule,
                  .close = region.close_mm / rules.unit_mm,
                  .offset = region.offset_mm / rules.unit_mm,
                  .miter_limit = region.miter_limit,
                  .always_list = rewrites || closed_.size() != items_.size()},
                 nester_);
    cancels_ = regions_.cancels();
    if (regions_.is_unchanged() && regions_.rings().empty()) {
        std::copy(regions_.nested().begin(), regions_.nested().end(), items_.begin());
        return;
    }
    walked_.swap(contours_);
    region_.assign(regions_.rings().begin(), regions_.rings().end());
    replace_by_rings();
    if (region.largest_only || rule == FillRule::outermost) {
        keep_some(rule == FillRule::outermost, region.largest_only);
        replace_by_rings();
    }
}

/// contours_ becomes the open polylines as they were walked, then the contours of the region.
void LayerBuilder::replace_by_rings() {
    contours_.clear();
    std::remove_copy_if(walked_.begin(), walked_.end(), std::back_inserter(contours_), is_closed);
    const auto polylines = static_cast<std::int64_t>(contours_.size());
    std::size_t points = 0;
    for (const Ring& ring : region_) {
        points += is_rewritten(ring) ? ring.item.count : 0;
    }
    made_.resize(points);
    made_origins_.resize(with_origins_ ? points : 0);
    Point* made = made_.data();
    for (const Ring& ring : region_) {
        pace_.spend(contour_work + ring.item.count);
        if (ring.given >= 0) {
            contours_.push_back(walked_[walked_of_[static_cast<std::size_t>(ring.given)]]);
        }
        if (is_rewritten(ring)) {
            const std::span<Point> all(made, ring.item.count);
            PointOrigin* const origins = with_origins_ ? made_origins_.data() + (made - made_.data()) : nullptr;
            made += ring.item.count;
            const LayerContour contour = closed_contour(all.first(rewrite(ring, all, origins)), origins);
            if (ring.given >= 0) {
                const std::uint16_t flags = contours_.back().item.flags;
                contours_.back().item = contour.item;
                contours_.back().item.flags = flags;
            } else {
                contours_.push_back(contour);
                contours_.back().made = true;
            }
        }
        contours_.back().item.part = ring.item.part;
    }
    sort_by_start();
    ring_of_.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        ring_of_.push_back(std::max<std::int64_t>(-1, order_.contour_of(i) - polylines));
    }
    region_nesting_.nest(items_, ring_of_, region_, nester_);
}

/// Writes the ring's points, and their origins unless null; returns how many points are left.
std::size_t LayerBuilder::rewrite(const Ring& ring, std::span<Point> points, PointOrigin* origins) const {
    std::copy_n(ring.item.points, ring.item.count, points.data());
    if (origins != nullptr && ring.item.origins != nullptr) {
        std::copy_n(ring.item.origins, ring.item.count, origins);
    } else if (origins != nullptr) {
        std::fill_n(origins, ring.item.count, PointOrigin());
    }
    const bool will_turn = (to_int128(ring.item.twice_area) > 0) == ring.hole;
    return rules.region->drop_collinear ? drop_collinear(points, origins, will_turn) : points.size();
}

bool LayerBuilder::is_rewritten(const Ring& ring) const noexcept {
    return ring.given < 0 || rules.region->drop_collinear;
}

/// Of region_ only those that lie in no other, or only the largest of these with its holes.
void LayerBuilder::keep_some(bool outermost, bool largest) {
    std::int32_t first = -1;
    for (std::size_t i = 0; i < items_.size() && largest; ++i) {
        const bool is_larger = items_[i].role == Role::outer &&
                               (first < 0 || size_of(items_[i]) > size_of(items_[static_cast<std::size_t>(first)]));
        first = is_larger ? static_cast<std::int32_t>(i) : first;
    }
    Vector<Ring>& kept = kept_;
    kept.clear();
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const NestItem& item = items_[i];
        const bool in_largest = static_cast<std::int32_t>(i) == first || (item.role == Role::hole && item.parent == first);
        if (ring_of_[i] >= 0 && (!outermost || item.parent < 0) && (!largest || in_largest)) {
            kept.push_back(region_[static_cast<std::size_t>(ring_of_[i])]);
            kept.back().touched = -1;  // holes and what lies in them have gone
        }
    }
    region_.swap(kept);
}

/// From the start on, backwards if need be.
void LayerBuilder::copy_points(const NestItem& item, Point* to) {
    const auto copy = [&](const Point* from, std::size_t count) {
        pace_.in_stretches(0, count, 1, [&](std::size_t begin, std::size_t end) {
            if (item.reverse) {
                std::reverse_copy(from + (count - end), from + (count - begin), to + begin);
            } else {
                std::copy(from + begin, from + end, to + begin);
            }
        });
        to += count;
    };
    const std::size_t first = item.reverse ? item.start + 1 : item.start;  // of the points that lie after the others
    if (item.reverse) {
        copy(item.points, first);
    }
    copy(item.points + first, item.count - first);
    if (!item.reverse) {
        copy(item.points, first);
    }
}

void LayerBuilder::copy_origins(const NestItem& item, PointOrigin* to) {
    const std::span<const PointOrigin> walked(item.origins, item.count);
    if (!item.reverse) {
        std::rotate_copy(walked.begin(), walked.begin() + item.start, walked.end(), to);
    } else {  // the start is the first point of the walk back that begins at it
        const std::size_t skipped = item.count - 1 - item.start;
        for (std::size_t i = 0; i < walked.size(); ++i) {
            const std::size_t place = skipped + i;
            to[i] = origin_turned_round(walked, place < walked.size() ? place : place - walked.size());
        }
    }
    pace_.spend(item.count);
}

void LayerBuilder::append(BandOutput& out) {
    const std::size_t base = out.contours.size();
    for (const std::uint32_t i : order_.items()) {
        const NestItem& item = items_[i];
        pace_.spend(contour_work);
        copy_points(item, out.reserve_points(item.count));
        if (out.with_origins) {
            copy_origins(item, out.origins + out.point_count);
        }
        Contour& contour = out.contours.emplace_back();
        contour.first_point = out.point_count;
        contour.twice_area = item.reverse ? to_integer128(-to_int128(item.twice_area)) : item.twice_area;
        contour.parent =
            item.parent < 0 ? -1 : static_cast<std::int64_t>(base + order_.place_of(static_cast<std::size_t>(item.parent)));
        contour.point_count = item.count;
        contour.segments = contours_[order_.contour_of(i)].segments;
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
