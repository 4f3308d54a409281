// The lowest and highest z of a facet, and sorting facets by such a height.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "method.hpp"

namespace lamella::baselines {

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

}  // namespace lamella::baselines
