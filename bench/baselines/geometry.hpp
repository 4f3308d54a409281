// Shared by all baselines: rounding facets to the grid, their heights and the planes between them, and cutting a facet by
// a plane. The rules are the engine's (lamella/grid.hpp), so equal contours are equal to the last bit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "methods.hpp"

namespace lamella::baselines {

/// The soup rounded to the grid, without facets that have two equal vertices.
std::vector<Facet> quantised(const Problem& problem);

/// True where the plane cuts the edge. The functions below require it.
inline bool is_cut(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept {
    return (a.z < plane) != (b.z < plane);
}
inline bool is_cut(const Facet& facet, std::int32_t plane) noexcept {
    return is_cut(facet[0], facet[1], plane) || is_cut(facet[1], facet[2], plane);
}

/// The point where the edge crosses the plane, interpolated from the lower vertex upwards.
Point crossing(const GridVertex& a, const GridVertex& b, std::int32_t plane) noexcept;

/// The segment of a facet that the plane cuts. It starts on the edge that the facet runs down and ends on the edge that
/// it runs up.
Segment cut(const Facet& facet, std::int32_t plane) noexcept;

inline std::int32_t z_min(const Facet& facet) noexcept {
    return std::min({facet[0].z, facet[1].z, facet[2].z});
}
inline std::int32_t z_max(const Facet& facet) noexcept {
    return std::max({facet[0].z, facet[1].z, facet[2].z});
}

/// The facets in ascending order of their key. Sorts keys and indices, which are smaller than facets. O(n log n).
template <class Key>
std::vector<Facet> sorted_by(const std::vector<Facet>& facets, const Key& key) {
    std::vector<std::pair<decltype(key(facets[0])), std::uint32_t>> order;
    order.reserve(facets.size());
    for (std::size_t t = 0; t < facets.size(); ++t) {
        order.emplace_back(key(facets[t]), static_cast<std::uint32_t>(t));
    }
    std::sort(order.begin(), order.end());
    std::vector<Facet> sorted;
    sorted.reserve(facets.size());
    for (const auto& [unused, t] : order) {
        sorted.push_back(facets[t]);
    }
    return sorted;
}

/// Items below a count, grouped by a key: those of key k are at [first[k], first[k + 1]) in `items`.
struct Groups {
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> items;

    std::span<std::uint32_t> of(std::size_t key) { return {items.data() + first[key], items.data() + first[key + 1]}; }
};

inline constexpr std::uint32_t no_key = 0xFFFFFFFF;

/// Leaves out items for which key(item) is no_key. O(count + keys).
template <class Key>
Groups grouped(std::uint32_t count, std::size_t keys, const Key& key) {
    std::vector<std::uint32_t> key_of(count);
    Groups groups{std::vector<std::uint32_t>(keys + 2), {}};
    for (std::uint32_t item = 0; item < count; ++item) {
        key_of[item] = key(item);
        if (key_of[item] != no_key) {
            ++groups.first[key_of[item] + 2];
        }
    }
    std::partial_sum(groups.first.begin(), groups.first.end(), groups.first.begin());
    groups.items.resize(groups.first.back());
    for (std::uint32_t item = 0; item < count; ++item) {
        if (key_of[item] != no_key) {
            groups.items[groups.first[key_of[item] + 1]++] = item;
        }
    }
    return groups;
}

/// Slices, which is timed by itself, then joins each layer's pieces, which are freed at once.
template <class Slice, class Join>
WholeOutcome in_two_steps(const Slice& slice, const Join& join) {
    const Clock::time_point start = Clock::now();
    auto layers = slice();
    WholeOutcome outcome;
    outcome.slicing_s = milliseconds_since(start) / 1000;
    outcome.contours.resize(layers.size());
    for (std::size_t i = 0; i < layers.size(); ++i) {
        outcome.segments += layers[i].size();
        outcome.contours[i] = join(layers[i]);
        std::exchange(layers[i], {});
    }
    return outcome;
}

/// Index of the first plane above a height; k if there is none. O(1) for uniform planes, O(log k) for others.
class FirstPlaneAbove {
public:
    explicit FirstPlaneAbove(const Problem& problem) noexcept
        : planes_(problem.planes), uniform_(problem.uniform), first_(problem.first), step_(problem.step) {}

    std::uint32_t operator()(std::int32_t z) const noexcept {
        if (!uniform_ || planes_.empty()) {
            return static_cast<std::uint32_t>(std::upper_bound(planes_.begin(), planes_.end(), z) - planes_.begin());
        }
        // Each plane is rounded to the grid by itself, so the quotient can be one too small or one too large.
        const double quotient = std::floor((z - first_) / step_) + 1;
        auto i = static_cast<std::size_t>(std::clamp(quotient, 0.0, static_cast<double>(planes_.size())));
        while (i < planes_.size() && planes_[i] <= z) {
            ++i;
        }
        while (i > 0 && planes_[i - 1] > z) {
            --i;
        }
        return static_cast<std::uint32_t>(i);
    }

private:
    std::span<const std::int32_t> planes_;
    bool uniform_;
    double first_;
    double step_;
};

}  // namespace lamella::baselines
