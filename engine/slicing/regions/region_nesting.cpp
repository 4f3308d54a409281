#include "slicing/regions/region_nesting.hpp"

#include <algorithm>

namespace lamella {

bool RegionNesting::nest(std::span<NestItem> items, std::span<const std::int64_t> region_of,
                         std::span<const RegionContour> region, std::size_t clusters, Nester& nester) {
    constexpr std::int32_t unknown = -2;
    item_of_.resize(region.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (region_of[i] >= 0) {
            item_of_[static_cast<std::size_t>(region_of[i])] = static_cast<std::int32_t>(i);
        }
    }
    cluster_parent_.assign(clusters, unknown);
    nester.nest(items);
    for (std::size_t i = 0; i < items.size(); ++i) {
        NestItem& item = items[i];
        if (item.orientation == 0) {
            continue;
        }
        const RegionContour& contour = region[static_cast<std::size_t>(region_of[i])];
        if (contour.cluster >= 0) {
            std::int32_t& parent = cluster_parent_[static_cast<std::size_t>(contour.cluster)];
            parent = parent == unknown ? item.parent : parent;
            item.parent = contour.around < 0 ? parent : item_of_[static_cast<std::size_t>(contour.around)];
        }
        item.reverse = contour.hole == (item.orientation > 0);
        item.orientation = static_cast<std::int8_t>(contour.hole ? -1 : 1);  // as stored, whatever the facets say
        item.role = contour.hole ? Role::hole : Role::outer;
        item.flags &= static_cast<std::uint16_t>(~orientation_overruled);
    }
    return std::all_of(items.begin(), items.end(), [items](const NestItem& item) {
        const Role around = item.parent < 0 ? Role::hole : items[static_cast<std::size_t>(item.parent)].role;
        return item.orientation == 0 || (around == Role::hole) == (item.role == Role::outer);
    });
}

}  // namespace lamella
