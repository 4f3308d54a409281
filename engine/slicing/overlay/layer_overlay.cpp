#include "slicing/overlay/layer_overlay.hpp"

#include <algorithm>
#include <string>

#include "base/guard.hpp"
#include "slicing/overlay/labels.hpp"

namespace lamella {

namespace {

constexpr std::size_t set_work = 32;  ///< as StopPace counts it

}  // namespace

std::uint32_t LayerOverlay::run(std::span<const LayerSet> sets, const Rule& rule, const LayerRules& after, std::uint64_t n,
                                BandOutput& out) {
    rings_.clear();
    layers_.rules = &after;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        add_region(sets[s], s, n);
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

void LayerOverlay::add_region(const LayerSet& set, std::size_t number, std::uint64_t n) {
    if (readers_.size() == number) {
        readers_.push_back(std::make_unique<SetReader>(worker_));
    }
    const std::int64_t weight = std::int64_t{1} << number;
    for (Path path : readers_[number]->list_region(set, n, layers_.rules->grid_mm, nester_)) {
        path.segments = path.made ? path.item.count : path.segments;
        // As a region has it: with the solid on the left.
        rings_.push_back({path, path.is_backward() ? -weight : weight});
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
