#include "slicing/regions/regions.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "slicing/grid/origins.hpp"
#include "slicing/offset/fold.hpp"
#include "slicing/regions/closed_item.hpp"

namespace lamella {

namespace {

constexpr std::size_t ring_work = 32;  ///< as StopPace counts it
constexpr std::size_t curve_work = 4;  ///< of a point

std::span<const Point> points_of(const NestItem& item) noexcept {
    return {item.points, item.count};
}

/// check_reach() refuses most of them beforehand. But miters on the way back from a dilated region may lead farther.
void refuse_beyond_grid(const RawCurve& curve) {
    if (curve.beyond_grid) {
        throw Refused{{ErrorCode::invalid_argument,
                       "a contour moved by closing or by an offset lies beyond the grid, which ends at " +
                           std::to_string(grid_limit) + " units; choose a coarser unit or a smaller radius"}};
    }
}

}  // namespace

Regions::Regions(const Memory* memory)
    : rings_(memory),
      input_(memory),
      items_(memory),
      curves_(memory),
      parts_(memory),
      is_alone_(memory),
      alone_(memory),
      turned_edges_(memory),
      from_start_(memory),
      folded_(memory),
      folded_origins_(memory),
      folded_of_(memory),
      folded_ends_(memory),
      turned_(memory),
      turned_origins_(memory),
      filled_(memory),
      moved_(memory),
      closed_(memory),
      moved_curves_(memory),
      closed_curves_(memory) {}

void Regions::follow(const StopCheck& host) noexcept {
    pace_.follow(host);
    for (Fill* fill : {&filled_, &moved_, &closed_}) {
        fill->follow(host);
    }
}

void Regions::run(std::span<const NestItem> contours, const RegionSteps& steps, Nester& nester) {
    filled_.run(contours, steps.rule, nester);
    unchanged_ = filled_.is_unchanged();
    rings_.clear();
    if (unchanged_ && steps.close == 0 && steps.offset == 0 && !steps.always_list) {
        return;
    }
    take_given(contours);
    take(filled_);
    if (steps.close != 0 || steps.offset != 0) {
        turn_backward_ones();
    }
    if (steps.close != 0) {
        close(steps, nester);
    }
    if (steps.offset != 0) {
        unchanged_ = false;
        offset(steps, nester);
    }
}

void Regions::take_given(std::span<const NestItem> contours) {
    input_.clear();
    for (std::size_t c = 0; c < contours.size(); ++c) {
        input_.push_back({.item = contours[c], .given = static_cast<std::int64_t>(c)});
    }
}

/// The region that `fill` has made of input_.
void Regions::take(Fill& fill) {
    rings_.clear();
    for (const RegionContour& contour : fill.region()) {
        pace_.spend(ring_work);
        if (contour.kept >= 0) {
            Ring& ring = rings_.emplace_back(input_[static_cast<std::size_t>(contour.kept)]);
            ring.hole = contour.hole;
            ring.touched = -1;
        } else {
            const NestItem item = closed_item(fill.points_of(contour), fill.origins_of(contour));
            rings_.push_back({.item = item, .touched = contour.touched, .hole = to_int128(item.twice_area) <= 0});
        }
        rings_.back().item.part = contour.part;
    }
}

/// Contours that are solid on their right, as of inverted shells.
void Regions::turn_backward_ones() {
    turned_.clear();
    turned_origins_.clear();
    const auto is_backward = [](const Ring& ring) { return (to_int128(ring.item.twice_area) > 0) == ring.hole; };
    for (const Ring& ring : rings_) {
        if (is_backward(ring)) {
            const std::span<const Point> points = points_of(ring.item);
            turned_.insert(turned_.end(), points.rbegin(), points.rend());
            for (std::size_t i = 0; i < points.size() && ring.item.origins != nullptr; ++i) {
                turned_origins_.push_back(origin_turned_round({ring.item.origins, points.size()}, i));
            }
            unchanged_ = false;
        }
    }
    std::span<const Point> rest(turned_);
    for (Ring& ring : rings_) {
        if (is_backward(ring)) {
            const std::size_t count = ring.item.count;
            const std::uint32_t part = ring.item.part;
            const PointOrigin* const origins =
                ring.item.origins == nullptr ? nullptr : turned_origins_.data() + (rest.data() - turned_.data());
            ring.item = closed_item(rest.first(count), origins);
            ring.item.part = part;
            ring.given = -1;
            rest = rest.subspan(count);
        }
    }
}

void Regions::close(const RegionSteps& steps, Nester& nester) {
    list_dilated(steps);
    fill_positive(moved_, nester);
    if (find_alone() && folded_.empty()) {
        return;
    }
    unchanged_ = false;
    list_eroded(steps);
    fill_positive(closed_, nester);
    take(closed_);
}

/// A ring with edges that turn round is folded if then none does, and its curve is that of the folded ring.
void Regions::list_dilated(const RegionSteps& steps) {
    clear_curves(moved_curves_);
    folded_.clear();
    folded_origins_.clear();
    folded_ends_.clear();
    for (const Ring& ring : rings_) {
        const std::span<const Point> points = points_of(ring.item);
        curves_.push_back(moved_curves_.append(points, steps.close, steps.miter_limit, RawOffset::Turned::omitted));
        parts_.push_back(ring.item.part);
        pace_.spend(curve_work * points.size());
        if (!curves_.back().directions_kept && !fold(ring.item, steps)) {
            curves_.back() = moved_curves_.append(points, steps.close, steps.miter_limit);
        }
        refuse_beyond_grid(curves_.back());
        folded_ends_.push_back(folded_.size());
    }
    input_.clear();
    list_curves(moved_curves_);
}

/// The ring that was looked at last. False if it cannot be folded so that nothing turns round. Edges are replaced from the
/// ring's start on, wherever its points begin.
bool Regions::fold(const NestItem& ring, const RegionSteps& steps) {
    const std::size_t begin = folded_.size();
    moved_curves_.list_turned_edges(ring.count, turned_edges_);
    for (std::uint32_t& edge : turned_edges_) {
        edge = edge >= ring.start ? edge - ring.start : edge + ring.count - ring.start;
    }
    std::sort(turned_edges_.begin(), turned_edges_.end());
    from_start_.resize(ring.count);
    std::rotate_copy(ring.points, ring.points + ring.start, ring.points + ring.count, from_start_.begin());
    folded_of_.clear();
    if (!fold_edges(from_start_, turned_edges_, steps.close, steps.miter_limit, folded_, folded_of_)) {
        return false;
    }
    const RawCurve curve =
        moved_curves_.append(std::span(folded_).subspan(begin), steps.close, steps.miter_limit, RawOffset::Turned::omitted);
    if (curve.reflex_cut || curve.count == 0) {
        folded_.resize(begin);
        return false;
    }
    curves_.back() = curve;
    if (ring.origins != nullptr) {
        keep_origins(ring);
    }
    return true;
}

/// Of the edges of the ring that folding has left as they were.
void Regions::keep_origins(const NestItem& ring) {
    const std::uint32_t count = ring.count;
    for (std::size_t i = 0; i < folded_of_.size(); ++i) {
        const std::uint32_t from = folded_of_[i];
        const std::uint32_t to = folded_of_[i + 1 < folded_of_.size() ? i + 1 : 0];
        const bool stayed = from != no_point && to == (from + 1 < count ? from + 1 : 0);
        folded_origins_.push_back(stayed ? ring.origins[(std::size_t{ring.start} + from) % count] : PointOrigin());
    }
}

/// Returns whether all are.
bool Regions::find_alone() {
    is_alone_.assign(rings_.size(), 0);
    std::size_t alone = 0;
    for (const RegionContour& contour : moved_.region()) {
        if (contour.kept >= 0) {
            const std::uint32_t ring = input_[static_cast<std::size_t>(contour.kept)].source;
            const RawCurve& curve = curves_[ring];
            is_alone_[ring] = curve.directions_kept && !curve.reflex_cut && contour.hole == rings_[ring].hole ? 1 : 0;
            alone += is_alone_[ring];
        }
    }
    return alone == rings_.size() && moved_.region().size() == rings_.size();
}

/// The ring without the edges that turn round.
Ring Regions::as_folded(std::uint32_t ring) const {
    Ring folded = rings_[ring];
    const std::size_t begin = ring == 0 ? 0 : folded_ends_[ring - 1];
    if (folded_ends_[ring] != begin) {
        const PointOrigin* const origins = folded_origins_.empty() ? nullptr : folded_origins_.data() + begin;
        folded = {.item = closed_item(std::span(folded_).subspan(begin, folded_ends_[ring] - begin), origins),
                  .hole = folded.hole};
        folded.item.part = rings_[ring].item.part;
    }
    return folded;
}

/// Of the dilated region, but for the rings left alone, which stay as they were or folded.
void Regions::list_eroded(const RegionSteps& steps) {
    clear_curves(closed_curves_);
    alone_.clear();
    for (const RegionContour& contour : moved_.region()) {
        if (contour.kept < 0) {
            append_curve(moved_.points_of(contour), contour.part, -steps.close, steps.miter_limit, closed_curves_);
            continue;
        }
        const Ring& curve = input_[static_cast<std::size_t>(contour.kept)];
        if (is_alone_[curve.source] != 0) {
            alone_.push_back(as_folded(curve.source));
        } else {
            append_curve(points_of(curve.item), contour.part, -steps.close, steps.miter_limit, closed_curves_);
        }
    }
    input_.swap(alone_);
    list_curves(closed_curves_);
}

void Regions::offset(const RegionSteps& steps, Nester& nester) {
    list_moved(steps.offset, steps.miter_limit);
    fill_positive(moved_, nester);
    take(moved_);
}

void Regions::list_moved(double distance, double miter_limit) {
    clear_curves(moved_curves_);
    for (const Ring& ring : rings_) {
        append_curve(points_of(ring.item), ring.item.part, distance, miter_limit, moved_curves_);
    }
    input_.clear();
    list_curves(moved_curves_);
}

void Regions::clear_curves(RawOffset& curves) {
    curves.clear();
    curves_.clear();
    parts_.clear();
}

void Regions::append_curve(std::span<const Point> points, std::uint32_t part, double distance, double miter_limit,
                           RawOffset& curves) {
    curves_.push_back(curves.append(points, distance, miter_limit));
    parts_.push_back(part);
    refuse_beyond_grid(curves_.back());
    pace_.spend(curve_work * points.size());
}

/// Adds the curves to input_, but for those that have vanished.
void Regions::list_curves(RawOffset& curves) {
    for (std::uint32_t c = 0; c < curves_.size(); ++c) {
        if (curves_[c].count > 0) {
            input_.push_back({.item = closed_item(curves.points_of(curves_[c])), .source = c});
            input_.back().item.part = parts_[c];
            pace_.spend(curves_[c].count);
        }
    }
}

/// What input_ bounds by the positive rule.
void Regions::fill_positive(Fill& fill, Nester& nester) {
    std::sort(input_.begin(), input_.end(), [this](const Ring& a, const Ring& b) {
        pace_.spend(1);
        return std::pair(a.item.from_start(0), a.source) < std::pair(b.item.from_start(0), b.source);
    });
    items_.clear();
    for (const Ring& ring : input_) {
        items_.push_back(ring.item);
    }
    fill.run(items_, FillRule::positive, nester);
}

void Regions::mark_near(std::span<NestItem> contours, double distance, double miter_limit, Nester& nester) {
    rings_.clear();
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (contours[c].orientation != 0) {
            rings_.push_back({.item = contours[c], .hole = contours[c].role == Role::hole, .source = c});
        }
    }
    turn_backward_ones();
    list_moved(distance, miter_limit);
    fill_positive(moved_, nester);
    find_alone();
    for (std::size_t r = 0; r < rings_.size(); ++r) {
        if (is_alone_[r] == 0) {
            contours[rings_[r].source].flags |= near_contour;
        }
    }
}

}  // namespace lamella
