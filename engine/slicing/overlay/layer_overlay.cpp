#include "slicing/overlay/layer_overlay.hpp"

#include <algorithm>
#include <string>
#include <tuple>

#include "base/guard.hpp"
#include "slicing/overlay/labels.hpp"

namespace lamella {

namespace {

constexpr std::size_t set_work = 32;  ///< as StopPace counts it

/// True if the set's contours in a layer are a region as they are: with the solid on their left, and across nothing.
bool is_region(const LayerSet& set) noexcept {
    const SliceResult* const stack = set.layers.stack();
    return stack != nullptr && set.from == set.to && set.grow_mm == 0 && !stack->info.options.region.keeps_contours() &&
           stack->info.options.region.fill_from.empty() &&
           (stack->info.part_count == 1 || stack->info.options.unite_parts || set.part);
}

/// Whatever it was made of, but for what the order of sets decides.
bool is_before(const Path& a, const Path& b) noexcept {
    if (a.item.from_start(0) != b.item.from_start(0)) {
        return a.item.from_start(0) < b.item.from_start(0);
    }
    if (const std::strong_ordering points = compare_points(a.item, b.item); points != 0) {
        return points < 0;
    }
    return std::tie(a.segments, a.item.flags) < std::tie(b.segments, b.item.flags);
}

}  // namespace

std::uint32_t LayerOverlay::run(std::span<const LayerSet> sets, const Rule& rule, const LayerRules& after, std::uint64_t n,
                                BandOutput& out) {
    rings_.clear();
    regions_.resize(std::max(regions_.size(), sets.size()));
    for (std::size_t s = 0; s < sets.size(); ++s) {
        given_.clear();
        list(sets[s], s, n);
        add_region(sets[s], s, after.grid_mm);
    }
    sort_rings();
    fill_.find_windings(paths_, weights_, nester_);
    const std::span<const std::int64_t> windings = fill_.list_windings();
    if (windings.front() < 0 || windings.back() >> sets.size() != 0) {
        throw Refused{
            {ErrorCode::invalid_argument, "layer " + std::to_string(n) +
                                              ": contours of a set wind twice or backwards around something, though "
                                              "it is said to be a region"}};
    }
    find_labels(rule, windings);
    layers_.rules = &after;
    std::uint32_t contours = 0;
    for (const std::uint32_t label : labels_) {
        fill_.select([&](std::int64_t winding) {
            const auto at = std::lower_bound(windings.begin(), windings.end(), winding);
            return label_of_[static_cast<std::size_t>(at - windings.begin())] == label;
        });
        contours += layers_.append_region(fill_, label - 1, out);
    }
    out.layer_contours.push_back(contours);
    return labels_.empty() ? 0 : labels_.back();
}

LayerOverlay::SetRegion& LayerOverlay::region_of(std::size_t set) {
    auto& region = regions_[set];
    if (region == nullptr) {
        region = std::make_unique<SetRegion>(worker_);
    }
    return *region;
}

void LayerOverlay::list(const LayerSet& set, std::size_t number, std::uint64_t n) {
    if (const ContourSet* const given = set.layers.given()) {
        of_host_.clear();
        for (const std::span<const Point> contour : given->contours) {
            if (!contour.empty()) {
                of_host_.push_back(given_path(contour));
            }
        }
        region_of(number).given.list(of_host_, given_);
    } else if (const LayerView* const layer = set.layers.layer()) {
        list(set, *layer);
    } else if (const SliceResult* const stack = set.layers.stack()) {
        for (std::int64_t own = set.from; own <= set.to; ++own) {
            const std::int64_t at = static_cast<std::int64_t>(n) + own;
            if (at >= 0 && at < static_cast<std::int64_t>(stack->size())) {
                list(set, (*stack)[static_cast<std::size_t>(at)]);
            }
        }
    }
}

/// Flat contours and open ones bound nothing.
void LayerOverlay::list(const LayerSet& set, const LayerView& layer) {
    for (const Contour& contour : layer.contours) {
        if (contour.role != Role::open && contour.role != Role::flat && (!set.part || *set.part == contour.part)) {
            Path& path = given_.emplace_back();
            path.item = closed_item(layer.points_of(contour));
            path.item.flags = static_cast<std::uint16_t>(contour.flags & (stitched | orientation_mixed));
            path.segments = contour.segments;
            worker_.spend(set_work + contour.point_count);
        }
    }
}

/// Adds what the listed contours bound to the rings.
void LayerOverlay::add_region(const LayerSet& set, std::size_t number, double grid_mm) {
    const std::int64_t weight = std::int64_t{1} << number;
    if (is_region(set)) {
        for (const Path& path : given_) {
            rings_.push_back({path, weight});
        }
        return;
    }
    std::sort(given_.begin(), given_.end(), [this](const Path& a, const Path& b) {
        worker_.spend(1);
        return is_before(a, b);
    });
    Regions& regions = region_of(number).regions;
    regions.run(given_, {.rule = set.fill_rule, .offset = set.grow_mm / grid_mm, .always_list = true}, nester_);
    for (Path path : regions.paths()) {
        path.segments = path.made ? path.item.count : path.segments;
        // As a region has it: with the solid on the left.
        const bool is_backward = (to_int128(path.item.twice_area) > 0) == path.hole;
        rings_.push_back({path, is_backward ? -weight : weight});
    }
}

void LayerOverlay::sort_rings() {
    std::sort(rings_.begin(), rings_.end(), [this](const Ring& a, const Ring& b) {
        worker_.spend(1);
        return is_before(a.path, b.path);
    });
    paths_.clear();
    weights_.clear();
    for (const Ring& ring : rings_) {
        paths_.push_back(ring.path);
        weights_.push_back(ring.weight);
        worker_.spend(set_work);
    }
}

/// Asks the rule once for each membership.
void LayerOverlay::find_labels(const Rule& rule, std::span<const std::int64_t> windings) {
    label_of_.clear();
    labels_.clear();
    for (const std::int64_t winding : windings) {
        const std::uint32_t label = label_of(rule, static_cast<std::uint64_t>(winding));
        require(check_label(label));
        label_of_.push_back(label);
        if (label != 0) {
            labels_.push_back(label);
        }
    }
    std::sort(labels_.begin(), labels_.end());
    labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
}

}  // namespace lamella
