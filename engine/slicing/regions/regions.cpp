#include "slicing/regions/regions.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/guard.hpp"
#include "base/numbers.hpp"
#include "base/sort.hpp"

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

void Regions::run(std::span<const Path> contours, const RegionSteps& steps, Nester& nester) {
    filled_.run(contours, steps.rule, nester);
    rings_.clear();
    unchanged_ = filled_.is_unchanged();
    if (unchanged_ && steps.close == 0 && steps.offset == 0 && !steps.always_list) {
        return;
    }
    go_on(filled_, steps, nester);
}

void Regions::go_on(const Fill& filled, const RegionSteps& steps, Nester& nester) {
    unchanged_ = filled.is_unchanged();
    take(filled);
    if (steps.close != 0 || steps.offset != 0) {
        turn_backward_ones();
    }
    if (steps.close != 0) {
        close(steps, nester);
    }
    if (steps.offset != 0) {
        unchanged_ = false;
        latest_ = nullptr;
        move(steps.offset, {.limit = steps.miter}, nester);
    }
}

void Regions::start_from(std::span<const Path> region) {
    latest_ = nullptr;
    rings_.assign(region.begin(), region.end());
    turn_backward_ones();
}

void Regions::widen(std::span<const Path> lines, double distance, const Corners& corners, Nester& nester) {
    clear(moved_curves_);
    for (const Path& line : lines) {
        if (!line.item.closed || line.item.count < 3) {
            if (line.item.count > 0) {
                add_curve(line.item, moved_curves_.append_line(points_of(line.item), distance, corners));
            }
            continue;
        }
        // Both ways round: the distance to the right of each is the distance to both sides.
        from_start_.assign(line.item.points, line.item.points + line.item.count);
        add_curve(line.item, moved_curves_.append(from_start_, distance, corners));
        std::reverse(from_start_.begin(), from_start_.end());
        add_curve(line.item, moved_curves_.append(from_start_, distance, corners));
    }
    list_curves(moved_curves_);
    fill_positive(moved_, nester);
    take(moved_);
    latest_ = &moved_;
}

void Regions::move(double distance, const Corners& corners, Nester& nester) {
    const bool second = latest_ == &moved_;  // the rings are what moved_ and its curves hold
    Fill& fill = second ? closed_ : moved_;
    RawOffset& curves = second ? closed_curves_ : moved_curves_;
    list_moved(curves, distance, corners);
    fill_positive(fill, nester);
    take(fill);
    latest_ = &fill;
}

void Regions::take(const Fill& fill) {
    worker_.spend(ring_work * fill.region().size());
    rings_.assign(fill.region().begin(), fill.region().end());
}

/// Contours that are solid on their right, as of inverted shells.
void Regions::turn_backward_ones() {
    turned_.clear();
    turned_origins_.clear();
    for (const Path& ring : rings_) {
        if (ring.is_backward()) {
            const std::span<const Point> points = points_of(ring.item);
            turned_.insert(turned_.end(), points.begin(), points.end());
            turned_origins_.insert(turned_origins_.end(), ring.item.origins,
                                   ring.item.origins + (ring.item.origins != nullptr ? points.size() : 0));
            unchanged_ = false;
        }
    }
    std::span<Point> rest(turned_);
    for (Path& ring : rings_) {
        if (ring.is_backward()) {
            const std::size_t count = ring.item.count;
            PointOrigin* const origins =
                ring.item.origins == nullptr ? nullptr : turned_origins_.data() + (rest.data() - turned_.data());
            turn_round(rest.first(count), origins, true);
            ring.item = closed_item(rest.first(count), origins, ring.item.part);
            ring.made = true;
            rest = rest.subspan(count);
        }
    }
}

void Regions::close(const RegionSteps& steps, Nester& nester) {
    folded_.clear();
    folded_origins_.clear();
    list_dilated(steps.close, {.limit = steps.miter});
    fill_positive(moved_, nester);
    if (find_alone() && folded_.empty()) {
        return;
    }
    unchanged_ = false;
    list_eroded(steps);
    fill_positive(closed_, nester);
    take(closed_);
}

/// None if there is no such ring, or if some edge of it would not keep its direction either. Precondition: the ring's curve
/// is the last one that was appended to moved_curves_.
std::optional<RawCurve> Regions::fold(const NestItem& ring, double distance, const Corners& corners) {
    const std::size_t begin = folded_.size();
    folded_of_.clear();
    RawCurve curve;
    if (moved_curves_.fold(folded_, folded_of_) && folded_.size() >= begin + 3) {
        curve = moved_curves_.append(std::span(folded_).subspan(begin), distance, corners);
    }
    if (!curve.directions_kept || curve.reflex_cut || curve.count == 0) {
        folded_.resize(begin);
        return {};
    }
    for (std::size_t i = 0; i < folded_of_.size() && ring.origins != nullptr; ++i) {
        const std::uint32_t from = folded_of_[i];
        const std::uint32_t to = folded_of_[i + 1 < folded_of_.size() ? i + 1 : 0];
        const bool stayed = from != no_point && to == (from + 1 < ring.count ? from + 1 : 0);
        folded_origins_.push_back(stayed ? ring.origins[from] : PointOrigin());
    }
    return curve;
}

/// Returns whether all are.
bool Regions::find_alone() {
    is_alone_.assign(rings_.size(), 0);
    std::size_t alone = 0;
    for (const Path& kept : moved_.kept()) {
        const std::uint32_t ring = kept.source;
        const RawCurve& curve = curves_[ring];
        is_alone_[ring] = curve.directions_kept && !curve.reflex_cut && kept.hole == rings_[ring].hole ? 1 : 0;
        alone += is_alone_[ring];
    }
    return alone == rings_.size() && moved_.region().size() == rings_.size();
}

/// The ring without the edges that turn round.
Path Regions::as_folded(std::uint32_t ring) const {
    Path folded = rings_[ring];
    const std::size_t begin = ring == 0 ? 0 : folded_ends_[ring - 1];
    if (folded_ends_[ring] != begin) {
        const PointOrigin* const origins = folded_origins_.empty() ? nullptr : folded_origins_.data() + begin;
        const auto points = std::span(folded_).subspan(begin, folded_ends_[ring] - begin);
        folded = {.item = closed_item(points, origins, folded.item.part), .made = true, .hole = folded.hole};
    }
    return folded;
}

/// Curves of the dilated region, but for the rings left alone, which stay as they were or folded.
void Regions::list_eroded(const RegionSteps& steps) {
    const Corners corners{.limit = steps.miter};
    clear(closed_curves_);
    for (const Path& kept : moved_.kept()) {
        if (is_alone_[kept.source] != 0) {
            input_.push_back(as_folded(kept.source));
        } else {
            add_curve(kept.item, closed_curves_.append(points_of(kept.item), -steps.close, corners));
        }
    }
    for (const Path& made : moved_.made()) {
        add_curve(made.item, closed_curves_.append(points_of(made.item), -steps.close, corners));
    }
    list_curves(closed_curves_);
}

void Regions::list_moved(RawOffset& curves, double distance, const Corners& corners) {
    clear(curves);
    for (const Path& ring : rings_) {
        add_curve(ring.item, curves.append(points_of(ring.item), distance, corners));
    }
    list_curves(curves);
}

/// Rings with edges that turn round are folded if then none does, and otherwise moved as they are.
void Regions::list_dilated(double distance, const Corners& corners) {
    clear(moved_curves_);
    folded_ends_.clear();
    for (const Path& ring : rings_) {
        RawCurve curve = moved_curves_.append(points_of(ring.item), distance, corners);
        if (!curve.directions_kept) {
            curve = fold(ring.item, distance, corners).value_or(curve);
        }
        add_curve(ring.item, curve);
        folded_ends_.push_back(folded_.size());
    }
    list_curves(moved_curves_);
}

void Regions::clear(RawOffset& curves) {
    input_.clear();
    curves.clear();
    curves_.clear();
    parts_.clear();
}

void Regions::add_curve(const NestItem& ring, const RawCurve& curve) {
    curves_.push_back(curve);
    parts_.push_back(ring.part);
    refuse_beyond_grid(curve);
    worker_.spend(curve_work * ring.count);
}

/// Adds the curves to input_, but for those that have vanished.
void Regions::list_curves(RawOffset& curves) {
    for (std::uint32_t c = 0; c < curves_.size(); ++c) {
        if (curves_[c].count > 0) {
            input_.push_back(
                {.item = closed_item(curves.points_of(curves_[c]), nullptr, parts_[c]), .made = true, .source = c});
            worker_.spend(curves_[c].count);
        }
    }
}

/// Fills the region that input_ bounds by the positive rule.
void Regions::fill_positive(Fill& fill, Nester& nester) {
    sort_briefly(input_.begin(), input_.end(), [this](const Path& a, const Path& b) {
        worker_.spend(1);
        return std::pair(a.item.from_start(0), a.source) < std::pair(b.item.from_start(0), b.source);
    });
    fill.run(input_, FillRule::positive, nester);
}

void Regions::mark_near(std::span<NestItem> contours, double distance, double miter, Nester& nester) {
    rings_.clear();
    for (std::uint32_t c = 0; c < contours.size(); ++c) {
        if (contours[c].orientation != 0) {
            rings_.push_back({.item = contours[c], .hole = contours[c].role == Role::hole, .source = c});
        }
    }
    turn_backward_ones();
    list_moved(moved_curves_, distance, {.limit = miter});
    fill_positive(moved_, nester);
    find_alone();
    for (std::size_t r = 0; r < rings_.size(); ++r) {
        if (is_alone_[r] == 0) {
            contours[rings_[r].source].flags |= would_close;
        }
    }
}

}  // namespace lamella
