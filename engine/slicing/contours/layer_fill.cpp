// Stage 6, where a fill rule was asked for: a layer's contours become those of the region that they fill.
#include <algorithm>
#include <iterator>

#include "slicing/contours/layer_builder.hpp"

namespace lamella {

/// False: the layer's contours are too entangled.
bool LayerBuilder::apply_fill_rule() {
    if (!fill_region()) {
        return false;
    }
    sort_by_start();
    return nest_region();
}

/// found_ becomes the region that the closed contours bound by the rule, and the polylines as they were. False: the contours
/// meet too often.
bool LayerBuilder::fill_region() {
    const auto is_closed = [](const NestItem& item) { return item.closed; };
    closed_.clear();
    std::copy_if(items_.begin(), items_.end(), std::back_inserter(closed_), is_closed);
    if (!fill_.run(closed_, rules.fill, nester_)) {
        return false;
    }
    walked_.swap(found_);
    found_.clear();
    std::copy_if(walked_.begin(), walked_.end(), std::back_inserter(found_),
                 [&](const Found& found) { return !is_closed(found.item); });
    const std::size_t polylines = found_.size();
    next_place_.clear();  // where the closed ones are in walked_
    for (const nesting::SortKey& key : by_start_) {
        if (is_closed(walked_[key.index].item)) {
            next_place_.push_back(key.index);
        }
    }
    for (const RegionContour& contour : fill_.region()) {
        Found found = contour.kept >= 0 ? walked_[next_place_[static_cast<std::size_t>(contour.kept)]]
                                        : describe_made(fill_.points_of(contour));
        found.around = contour.around < 0 ? -1 : contour.around + static_cast<std::int64_t>(polylines);
        found.cluster = contour.cluster;
        found.hole = contour.hole;
        found_.push_back(found);
    }
    return true;
}

LayerBuilder::Found LayerBuilder::describe_made(std::span<Point> ring) const {
    const auto count = static_cast<std::uint32_t>(ring.size());
    return describe({0, count, true, false}, ring.data(), examine_ring(ring.data(), count),
                    [](std::uint32_t) { return EndKey{}; });
}

/// What lies in what: of contours that were clipped together, which may touch, clipping has told, and all of them lie in
/// what the first to start lies in; the rest touches nothing. False where that does not fit together.
bool LayerBuilder::nest_region() {
    place_of_.resize(items_.size());  // at first: of what was found
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        place_of_[by_start_[i].index] = i;
    }
    constexpr std::int32_t unknown = -2;
    around_clusters_.assign(fill_.clusters(), unknown);
    nester_.nest(items_);
    for (std::uint32_t i = 0; i < items_.size(); ++i) {
        NestItem& item = items_[i];
        if (item.sense == 0) {
            continue;
        }
        const Found& found = found_[by_start_[i].index];
        if (found.cluster >= 0) {
            std::int32_t& around = around_clusters_[static_cast<std::size_t>(found.cluster)];
            around = around == unknown ? item.parent : around;
            item.parent =
                found.around < 0 ? around : static_cast<std::int32_t>(place_of_[static_cast<std::size_t>(found.around)]);
        }
        item.reverse = found.hole == (item.sense > 0);
        item.sense = static_cast<std::int8_t>(found.hole ? -1 : 1);  // a region's, whatever the facets' was
        item.role = found.hole ? Role::hole : Role::outer;
        item.flags &= static_cast<std::uint16_t>(~sense_overruled);
    }
    return std::all_of(items_.begin(), items_.end(), [this](const NestItem& item) {
        const Role around = item.parent < 0 ? Role::hole : items_[static_cast<std::size_t>(item.parent)].role;
        return item.sense == 0 || (around == Role::hole) == (item.role == Role::outer);
    });
}

}  // namespace lamella
