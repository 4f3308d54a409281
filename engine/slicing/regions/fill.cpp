#include "slicing/regions/fill.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <numeric>

#include "base/numbers.hpp"

namespace lamella {

namespace {

constexpr std::size_t item_work = 4;  ///< as StopPace counts it

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
    contours_ = contours;
    region_.clear();
    points_.clear();
    origins_.clear();
    with_origins_ =
        std::any_of(contours.begin(), contours.end(), [](const Path& path) { return path.item.origins != nullptr; });
    cancels_ = false;
    merge_equal_ones();
    cancels_ = cancels_ && unites_inverted(rule);
    contacts_.find(items_);
    unchanged_ = !contacts_.any_meets() && items_.size() == contours.size();
    if (contacts_.any_meets()) {
        overlay(rule, nester);
    } else {
        keep_or_drop_all(rule, nester);
        kept_ = region_.size();
    }
}

void Fill::merge_equal_ones() {
    items_.clear();
    firsts_.clear();
    times_.clear();
    for (std::uint32_t c = 0; c < contours_.size(); ++c) {
        worker_.spend(item_work);
        const NestItem& item = contours_[c].item;
        if (c > 0 && std::is_eq(compare_points(contours_[c - 1].item, item))) {
            ++times_.back();
            items_.back().part = part_of_both(items_.back().part, item.part);
        } else {
            cancels_ = cancels_ || (!items_.empty() && are_opposite(items_.back(), item));
            items_.push_back(item);
            firsts_.push_back(c);
            times_.push_back(1);
        }
    }
}

/// No contour meets another: parents come before their children.
void Fill::keep_or_drop_all(FillRule rule, Nester& nester) {
    nester.nest(items_);
    inside_.resize(items_.size());
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        const std::int32_t parent = items_[c].parent;
        assert(parent < static_cast<std::int32_t>(c) && "a parent starts before its children");
        const std::size_t kept = region_.size();
        inside_[c] = keep_or_drop(c, parent < 0 ? 0 : inside_[static_cast<std::size_t>(parent)], rule);
        const bool as_nested = region_.size() > kept && !items_[c].reverse &&
                               region_.back().hole == (items_[c].role == Role::hole) &&
                               (items_[c].flags & orientation_overruled) == 0;
        unchanged_ = unchanged_ && as_nested;
    }
}

/// Returns the winding number just inside the contour.
std::int64_t Fill::keep_or_drop(std::uint32_t contour, std::int64_t around, FillRule rule) {
    worker_.spend(item_work);
    const std::int64_t inside = around + items_[contour].orientation * times_[contour];
    if (fills(rule, inside) != fills(rule, around)) {
        Path& kept = region_.emplace_back(contours_[firsts_[contour]]);
        kept.item.part = items_[contour].part;
        kept.hole = !fills(rule, inside);
        kept.touched = -1;
    }
    return inside;
}

void Fill::overlay(FillRule rule, Nester& nester) {
    snapped_.clear();
    bool any_inwards = false;  // else what is below zero are loops of contours that cross themselves
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        if (contacts_.meets(c)) {
            any_inwards = any_inwards || to_int128(items_[c].twice_area) < 0;
            snapped_.add(items_[c], times_[c], contacts_.near_edges(c));
        }
    }
    snapped_.run(contacts_.crossings());
    arrangement_.build(snapped_);
    around_.assign(arrangement_.components().size(), 0);
    list_pieces();
    nest_pieces(nester);
    find_windings(rule);
    if (unites_inverted(rule) && any_inwards) {
        find_cancelled();
    }
    take_traced(rule);
}

/// None if everything hangs together: nothing lies around it.
void Fill::list_pieces() {
    pieces_.clear();
    for (std::uint32_t c = 0; c < items_.size(); ++c) {
        if (!contacts_.meets(c)) {
            pieces_.push_back({c, -1});
        }
    }
    if (pieces_.empty() && around_.size() <= 1) {
        return;
    }
    for (std::uint32_t f = 0; f < arrangement_.faces().size(); ++f) {
        const std::uint32_t component = arrangement_.faces()[f].component;
        if (arrangement_.components()[component].around != f) {
            pieces_.push_back({-1, f});
        }
    }
}

void Fill::nest_pieces(Nester& nester) {
    face_points_.clear();
    face_ends_.clear();
    for (const Piece& piece : pieces_) {
        if (piece.face >= 0) {
            arrangement_.append_points_of(arrangement_.faces()[static_cast<std::size_t>(piece.face)], face_points_);
        }
        face_ends_.push_back(face_points_.size());
    }
    piece_items_.clear();
    piece_items_.reserve(pieces_.size());
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
        worker_.spend(item_work);
        const std::size_t begin = p == 0 ? 0 : face_ends_[p - 1];
        piece_items_.push_back(pieces_[p].contour >= 0
                                   ? items_[static_cast<std::size_t>(pieces_[p].contour)]
                                   : closed_item(std::span(face_points_).subspan(begin, face_ends_[p] - begin)));
    }
    nester.nest(piece_items_);
}

/// Winding numbers around the components, and in the contours that meet no other, which are kept or dropped by them.
void Fill::find_windings(FillRule rule) {
    order_.resize(pieces_.size());
    std::iota(order_.begin(), order_.end(), 0U);
    std::sort(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
        worker_.spend(1);
        return piece_items_[a].from_start(0) < piece_items_[b].from_start(0);
    });
    inside_.resize(pieces_.size());
    around_known_.assign(around_.size(), 0);
    for (const std::uint32_t p : order_) {  // what lies around starts before
        const std::int32_t parent = piece_items_[p].parent;
        const std::int64_t around = parent < 0 ? 0 : inside_[static_cast<std::size_t>(parent)];
        if (pieces_[p].contour >= 0) {
            const auto contour = static_cast<std::uint32_t>(pieces_[p].contour);
            items_[contour].orientation = piece_items_[p].orientation;
            inside_[p] = keep_or_drop(contour, around, rule);
            continue;
        }
        const Arrangement::Face& face = arrangement_.faces()[static_cast<std::size_t>(pieces_[p].face)];
        if (around_known_[face.component] == 0) {  // the first of the component's faces has its smallest point
            around_[face.component] = around;
            around_known_[face.component] = 1;
        }
        inside_[p] = around_[face.component] + face.winding;
    }
}

/// Edges that opposite ones have cancelled may have hung together.
void Fill::find_cancelled() {
    const auto winding = [this](const Arrangement::Face& face) { return around_[face.component] + face.winding; };
    const auto below = [this](const Arrangement::Face& face) -> std::uint8_t& {
        return below_zero_[snapped_.any_cancelled() ? 0 : face.component];
    };
    below_zero_.assign(around_.size(), 0);
    for (const Arrangement::Face& face : arrangement_.faces()) {
        below(face) = below(face) != 0 || (winding(face) < 0 && is_wide(face)) ? 1 : 0;
    }
    for (const Arrangement::Face& face : arrangement_.faces()) {
        cancels_ = cancels_ || (below(face) != 0 && winding(face) > 0 && is_wide(face));
    }
}

/// Wider than the two units by which rounding may move edges that touch over one another.
bool Fill::is_wide(const Arrangement::Face& face) {
    face_points_.clear();
    arrangement_.append_points_of(face, face_points_);
    Int128 twice_area = 0;
    std::int64_t length = 0;
    for (std::size_t i = 0; i < face_points_.size(); ++i) {
        const Point a = face_points_[i];
        const Point b = face_points_[i + 1 < face_points_.size() ? i + 1 : 0];
        twice_area += Int128{a.x} * b.y - Int128{b.x} * a.y;
        length += std::abs(std::int64_t{b.x} - a.x) + std::abs(std::int64_t{b.y} - a.y);
    }
    return twice_area > 2 * Int128{length};
}

void Fill::take_traced(FillRule rule) {
    kept_ = region_.size();
    arrangement_.trace(rule, around_, region_, points_, with_origins_ ? &origins_ : nullptr);
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
