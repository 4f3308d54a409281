#include "slicing/regions/region_nesting.hpp"

#include <algorithm>
#include <cassert>

namespace lamella {

void RegionNesting::nest(std::span<NestItem> items, std::span<const std::int64_t> ring_of, std::span<const Ring> rings,
                         Nester& nester) {
    item_of_.resize(rings.size());
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        if (ring_of[i] >= 0) {
            item_of_[static_cast<std::size_t>(ring_of[i])] = i;
        }
    }
    nester.nest(items);
    is_settled_.assign(items.size(), 0);
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        NestItem& item = items[i];
        if (item.orientation == 0) {
            continue;
        }
        const bool hole = rings[static_cast<std::size_t>(ring_of[i])].hole;
        item.reverse = hole == (item.orientation > 0);
        item.orientation = static_cast<std::int8_t>(hole ? -1 : 1);  // as stored, whatever the facets say
        item.role = hole ? Role::hole : Role::outer;
        item.flags &= static_cast<std::uint16_t>(~orientation_overruled);
    }
    // What is touched starts before, or at the same point: the way to one that is settled is short.
    for (std::uint32_t i = 0; i < items.size(); ++i) {
        std::uint32_t at = i;
        const auto touched = [&] { return ring_of[at] < 0 ? -1 : rings[static_cast<std::size_t>(ring_of[at])].touched; };
        while (is_settled_[at] == 0 && items[at].role == Role::outer && touched() >= 0) {
            at = item_of_[static_cast<std::size_t>(touched())];
        }
        if (at != i) {
            items[i].parent = items[at].role == Role::hole ? static_cast<std::int32_t>(at) : items[at].parent;
        }
        is_settled_[i] = 1;
    }
    assert(std::all_of(items.begin(), items.end(), [items](const NestItem& item) {
        const Role around = item.parent < 0 ? Role::hole : items[static_cast<std::size_t>(item.parent)].role;
        return item.orientation == 0 || (around == Role::hole) == (item.role == Role::outer);
    }));
}

}  // namespace lamella
