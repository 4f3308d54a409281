// Stage 6, where a fill rule was asked for: a layer's contours become those of the region that they fill.
#include <algorithm>

#include "6_contours/layer_builder.hpp"

namespace lamella {

/// found_ becomes the region that the closed contours bound by the rule, and the polylines as they were.
void LayerBuilder::fill_regions() {
    fill_.clear();
    add_to_fill();
    std::erase_if(found_, [](const Found& found) { return found.item.closed; });
    const std::size_t polylines = found_.size();
    filled_.clear();
    fill_.fill(rules.fill, [this, polylines](std::span<const Point> contour, std::int64_t around) {
        Found& found = found_.emplace_back();
        found.segments = static_cast<std::uint32_t>(contour.size());
        found.around = around < 0 ? -1 : around + static_cast<std::int64_t>(polylines);
        filled_.insert(filled_.end(), contour.begin(), contour.end());
    });
    Point* ring = filled_.data();
    for (std::size_t c = polylines; c < found_.size(); ++c) {
        const std::uint32_t count = found_[c].segments;
        const std::int64_t around = found_[c].around;
        found_[c] =
            describe({0, count, true, false}, ring, examine_ring(ring, count), [](std::uint32_t) { return EndKey{}; });
        found_[c].around = around;
        found_[c].hole = around >= 0 && !found_[static_cast<std::size_t>(around)].hole;
        ring += count;
    }
}

/// Of contours that are the same, a body exported many times, only those that matter: the clipping library takes cubic time
/// for many.
void LayerBuilder::add_to_fill() {
    const auto same = [](const NestItem& a, const NestItem& b) {
        std::uint32_t i = 0;
        while (a.closed == b.closed && a.count == b.count && i < a.count && a.from_start(i) == b.from_start(i)) {
            ++i;
        }
        return a.closed == b.closed && i == a.count && i == b.count;
    };
    const bool no_negative = std::all_of(
        items_.begin(), items_.end(), [](const NestItem& item) { return !item.closed || from_wide(item.twice_area) >= 0; });
    for (std::size_t first = 0; first < items_.size();) {
        const NestItem& item = items_[first];
        std::size_t last = first + 1;
        while (last < items_.size() && same(item, items_[last])) {
            ++last;
        }
        const std::size_t times = last - first;
        const std::size_t kept = rules.fill == FillRule::even_odd ? times % 2 : (no_negative ? 1 : times);
        for (std::size_t i = 0; item.closed && i < kept; ++i) {
            fill_.add({item.points + item.start, item.count - item.start}, {item.points, item.start});
        }
        first = last;
    }
}

/// What lies in what is the clipping library's answer: contours of a region touch, and a start may lie on what is around it.
void LayerBuilder::nest_region() {
    place_of_.resize(items_.size());  // at first: of what was found
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        place_of_[by_start_[i].index] = i;
    }
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        NestItem& item = items_[i];
        const Found& found = found_[by_start_[i].index];
        item.reset();
        if (item.sense == 0) {
            continue;
        }
        item.role = found.hole ? Role::hole : Role::outer;
        item.reverse = found.hole == (item.sense > 0);
        item.parent = found.around < 0 ? -1 : static_cast<std::int32_t>(place_of_[static_cast<std::size_t>(found.around)]);
    }
}

}  // namespace lamella
