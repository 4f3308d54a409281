#include "slicing/overlay/layer_overlay.hpp"

#include <algorithm>
#include <bit>
#include <string>

#include "base/guard.hpp"
#include "base/sort.hpp"
#include "slicing/overlay/labels.hpp"

namespace lamella {

namespace {

constexpr std::size_t set_work = 32;  ///< as StopPace counts it
constexpr int winding_bits = 63;      ///< without the sign

}  // namespace

std::uint32_t LayerOverlay::run(std::span<const LayerSet> sets, const Rule& rule, const LayerRules& after, std::uint64_t n,
                                BandOutput& out) {
    layers_.rules = &after;
    add_sets(sets, n);
    sort_rings();
    fill_.find_windings(paths_, weights_, nester_);
    const std::span<const std::int64_t> windings = fill_.list_windings();
    find_labels(rule, windings, n);
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

void LayerOverlay::list_fields(std::span<const LayerSet> sets, std::uint64_t n) {
    fields_.clear();
    int all_bits = 0;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        if (readers_.size() == s) {
            readers_.push_back(std::make_unique<SetReader>(worker_));
        }
        Field& field = fields_.emplace_back();
        if (!SetReader::is_region(sets[s]) && sets[s].grow_mm == 0) {
            field.contours = readers_[s]->list_contours(sets[s], n);
            std::uint64_t turns = 0;  // a contour winds at most once for each two of its points
            for (const Path& path : field.contours) {
                turns += path.item.count / 2;
            }
            field.rule = sets[s].fill_rule;
            field.bits = static_cast<int>(std::bit_width(turns)) + 1;
        }
        all_bits += field.bits;
    }
    if (all_bits > winding_bits) {  // whichever comes first
        fields_.assign(sets.size(), {});
    }
}

void LayerOverlay::add_sets(std::span<const LayerSet> sets, std::uint64_t n) {
    list_fields(sets, n);
    rings_.clear();
    int shift = 0;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        const std::int64_t weight = std::int64_t{1} << shift;
        shift += fields_[s].bits;
        for (const Path& path : fields_[s].contours) {
            rings_.push_back({path, weight});
        }
        if (!fields_[s].is_region()) {
            continue;
        }
        for (Path path : readers_[s]->list_region(sets[s], n, layers_.rules->grid_mm, nester_)) {
            path.segments = path.made ? path.item.count : path.segments;
            // As a region has it: with the solid on the left.
            rings_.push_back({path, path.is_backward() ? -weight : weight});
        }
    }
}

/// By bits, the sets that hold what has the winding number.
std::uint64_t LayerOverlay::membership_of(std::int64_t winding, std::uint64_t n) const {
    std::uint64_t in = 0;
    for (std::size_t s = 0; s < fields_.size(); ++s) {
        const Field& field = fields_[s];
        const std::int64_t end = std::int64_t{1} << field.bits;
        const std::int64_t low = winding & (end - 1);
        const std::int64_t own = !field.is_region() && low >= end / 2 ? low - end : low;
        winding = (winding - own) >> field.bits;
        in |= std::uint64_t{field.is_region() ? own != 0 : fills(field.rule, own)} << s;
    }
    if (winding != 0) {
        throw Refused{
            {ErrorCode::invalid_argument, "layer " + std::to_string(n) +
                                              ": contours of a set wind twice or backwards around something, though "
                                              "it is said to be a region"}};
    }
    return in;
}

void LayerOverlay::sort_rings() {
    sort_briefly(rings_.begin(), rings_.end(), [this](const Ring& a, const Ring& b) {
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
void LayerOverlay::find_labels(const Rule& rule, std::span<const std::int64_t> windings, std::uint64_t n) {
    label_of_.clear();
    labels_.clear();
    for (const std::int64_t winding : windings) {
        const std::uint32_t label = label_of(rule, membership_of(winding, n));
        require(check_label(label));
        label_of_.push_back(label);
        if (label != 0) {
            labels_.push_back(label);
        }
    }
    sort_briefly(labels_.begin(), labels_.end());
    labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
}

}  // namespace lamella
