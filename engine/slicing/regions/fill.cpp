#include "slicing/regions/fill.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <iterator>
#include <numeric>

#include "base/numbers.hpp"
#include "base/sort.hpp"

namespace lamella {

namespace {

constexpr std::size_t path_work = 4;  ///< as StopPace counts it

bool unites_inverted(FillRule rule) noexcept {
    return rule == FillRule::non_zero || rule == FillRule::outermost;
}

/// True if one is the other walked backwards, as of a shell and its copy turned inside out.
bool are_opposite(const NestItem& a, const NestItem& b) noexcept {
    return a.from_start(0) == b.from_start(0) && a.count == b.count && to_int128(a.twice_area) == -to_int128(b.twice_area) &&
           to_int128(a.twice_area) != 0;
}

}  // namespace

void Fill::run(std::span<const Path> contours, FillRule rule, Nester& nester) {
    assert(rule != FillRule::contours);
    find_windings(contours, {}, nester);
    select([rule](std::int64_t winding) { return fills(rule, winding); });
    cancels_ = cancels_ && unites_inverted(rule);
    if (contacts_.any_meets()) {
        find_cancelled(rule);
    }
}

void Fill::find_windings(std::span<const Path> contours, std::span<const std::int64_t> weights, Nester& nester) {
    contours_ = contours;
    with_origins_ =
        std::any_of(contours.begin(), contours.end(), [](const Path& path) { return path.item.origins != nullptr; });
    cancels_ = false;
    merge_equal_ones(weights);
    contacts_.find(items_);
    merged_ = items_.size() != contours.size();
    overlay();
    list_pieces();
    nester.nest(pieces_);
    spread_windings();
}

std::span<const std::int64_t> Fill::list_windings() {
    windings_.assign(1, 0);
    for (std::uint32_t p = 0; p < apart_; ++p) {
        windings_.insert(windings_.end(), {around(p), inside_[p]});
    }
    for (const Arrangement::Face& face : arrangement_.faces()) {
        windings_.push_back(winding_of(face));
    }
    sort_briefly(windings_.begin(), windings_.end());
    windings_.erase(std::unique(windings_.begin(), windings_.end()), windings_.end());
    return windings_;
}

void Fill::select(FunctionRef<bool(std::int64_t)> fills) {
    region_.clear();
    points_.clear();
    origins_.clear();
    unchanged_ = !contacts_.any_meets() && !merged_;
    for (const std::uint32_t p : order_) {
        if (p < apart_) {
            keep_or_drop(p, fills);
        }
    }
    kept_ = region_.size();
    if (contacts_.any_meets()) {
        take_traced(fills);
    }
}

void Fill::merge_equal_ones(std::span<const std::int64_t> weights) {
    items_.clear();
    firsts_.clear();
    times_.clear();
    for (std::uint32_t c = 0; c < contours_.size(); ++c) {
        worker_.spend(path_work);
        const NestItem& item = contours_[c].item;
        const std::int64_t weight = weights.empty() ? 1 : weights[c];
        if (c > 0 && compare_points(contours_[c - 1].item, item) == 0) {
            times_.back() += weight;
            items_.back().part = part_of_both(items_.back().part, item.part);
        } else {
            cancels_ = cancels_ || (!items_.empty() && are_opposite(items_.back(), item));
            items_.push_back(item);
            firsts_.push_back(c);
            times_.push_back(weight);
        }
    }
}

void Fill::overlay() {
    snapped_.clear();
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        if (contacts_.meets(c)) {
            snapped_.add(items_[c], times_[c], contacts_.near(c));
        }
    }
    snapped_.run(contacts_.crossings());
    arrangement_.build(snapped_);
    around_.assign(arrangement_.outer_faces().size(), 0);
}

void Fill::list_pieces() {
    pieces_.clear();
    numbers_.clear();
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        worker_.spend(path_work);
        if (!contacts_.meets(c)) {
            numbers_.push_back(c);
        }
    }
    apart_ = numbers_.size();
    if (apart_ == items_.size()) {
        pieces_.swap(items_);
        return;
    }
    std::transform(numbers_.begin(), numbers_.end(), std::back_inserter(pieces_),
                   [this](std::uint32_t c) { return items_[c]; });
    if (apart_ > 0 || around_.size() > 1) {  // else nothing lies around the one component
        list_faces();
    }
}

/// Those that something else may lie in, and of each component the first, by which is known what lies around it.
void Fill::list_faces() {
    const std::span<const Arrangement::Face> faces = arrangement_.faces();
    arrangement_.list_extents(extents_);
    starts_.clear();
    std::transform(pieces_.begin(), pieces_.end(), std::back_inserter(starts_),
                   [](const NestItem& item) { return item.from_start(0); });
    starts_.resize(apart_ + around_.size(), Arrangement::Extent().smallest);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        Point& start = starts_[apart_ + faces[f].component];
        start = std::min(start, extents_[f].smallest);
    }
    start_tree_.assign(starts_.size(), [this](std::size_t i) { return starts_[i]; });
    face_points_.clear();
    face_ends_.clear();
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        const std::size_t own = apart_ + faces[f].component;
        const bool is_first = extents_[f].smallest == starts_[own];
        worker_.spend(path_work);
        bool holds = false;
        start_tree_.find_in(extents_[f].box, [&](Point, std::uint32_t i) {
            holds = i != own;
            return !holds;
        });
        if (arrangement_.outer_faces()[faces[f].component] != f && (is_first || holds)) {
            arrangement_.append_points_of(faces[f], face_points_);
            face_ends_.push_back(face_points_.size());
            numbers_.push_back(f);
        }
    }
    std::size_t begin = 0;
    for (const std::size_t end : face_ends_) {
        pieces_.push_back(closed_item(std::span(face_points_).subspan(begin, end - begin)));
        begin = end;
    }
}

/// Around the components, and in the contours that meet no other.
void Fill::spread_windings() {
    order_.resize(pieces_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    if (apart_ < pieces_.size()) {  // contours are in order
        sort_briefly(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
            worker_.spend(1);
            return pieces_[a].from_start(0) < pieces_[b].from_start(0);
        });
    }
    inside_.resize(pieces_.size());
    around_known_.assign(around_.size(), 0);
    for (const std::uint32_t p : order_) {  // what lies around starts before
        worker_.spend(path_work);
        if (p < apart_) {
            inside_[p] = around(p) + pieces_[p].orientation * times_[numbers_[p]];
            continue;
        }
        const Arrangement::Face& face = arrangement_.faces()[numbers_[p]];
        if (around_known_[face.component] == 0) {  // the first of the component's faces lies in none of the others
            around_[face.component] = around(p);
            around_known_[face.component] = 1;
        }
        inside_[p] = winding_of(face);
    }
}

void Fill::keep_or_drop(std::uint32_t piece, FunctionRef<bool(std::int64_t)> fills) {
    const NestItem& item = pieces_[piece];
    const bool hole = !fills(inside_[piece]);
    const bool stays = hole == fills(around(piece));
    if (stays) {
        Path& kept = region_.emplace_back(contours_[firsts_[numbers_[piece]]]);
        kept.item.part = item.part;
        kept.hole = hole;
        kept.touched = -1;
    }
    unchanged_ = unchanged_ && stays && !item.reverse && hole == (item.role == Role::hole) &&
                 (item.flags & orientation_overruled) == 0;
}

void Fill::find_cancelled(FillRule rule) {
    bool any_inwards = false;  // else what is below zero are loops of contours that cross themselves
    for (std::uint32_t c = 0; c < items_.size() && unites_inverted(rule); ++c) {
        any_inwards = any_inwards || (contacts_.meets(c) && to_int128(items_[c].twice_area) < 0);
    }
    if (!any_inwards) {
        return;
    }
    below_zero_.assign(around_.size(), 0);
    const auto together = [this](const Arrangement::Face& face) {  // edges that have cancelled may have hung together
        return snapped_.any_cancelled() ? 0 : face.component;
    };
    for (const Arrangement::Face& face : arrangement_.faces()) {
        if (winding_of(face) < 0 && is_wide(face)) {
            below_zero_[together(face)] = 1;
        }
    }
    for (const Arrangement::Face& face : arrangement_.faces()) {
        const bool above_zero = winding_of(face) > 0;
        cancels_ = cancels_ || (below_zero_[together(face)] != 0 && above_zero && is_wide(face));
    }
}

/// Wider than the two units by which rounding may move edges that touch over one another.
bool Fill::is_wide(const Arrangement::Face& face) {
    face_points_.clear();
    arrangement_.append_points_of(face, face_points_);
    std::int64_t length = 0;
    Point a = face_points_.back();
    for (const Point b : face_points_) {
        length += std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
        a = b;
    }
    return examine_ring(face_points_.data(), face_points_.size()).twice_area > 2 * Int128{length};
}

void Fill::take_traced(FunctionRef<bool(std::int64_t)> fills) {
    filled_.clear();
    for (const Arrangement::Face& face : arrangement_.faces()) {
        filled_.push_back(fills(winding_of(face)) ? 1 : 0);
        worker_.spend(1);
    }
    arrangement_.trace(filled_, region_, points_, with_origins_ ? &origins_ : nullptr);
    std::size_t first = 0;  // of a contour's points
    for (Path& made : std::span(region_).subspan(kept_)) {
        const std::size_t count = made.item.count;
        made.item = closed_item(std::span(points_).subspan(first, count), with_origins_ ? origins_.data() + first : nullptr,
                                made.item.part);
        made.hole = to_int128(made.item.twice_area) <= 0;
        first += count;
    }
}

}  // namespace lamella
