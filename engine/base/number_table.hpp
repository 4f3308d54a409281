// Distinct items, numbered in the order in which they come: open addressing, at most half full. Its memory is kept.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamella {

/// Slots are taken by the highest bits of an item's hash.
template <class Item, std::uint64_t (*hash)(const Item&) noexcept>
class NumberTable {
public:
    /// Forgets all items, and makes room for about `count`; beyond that it grows.
    void clear(std::size_t count) {
        constexpr std::size_t least_room = 512;
        items_.clear();
        resize(std::bit_ceil(2 * std::max(count, least_room)));
    }

    /// That of an item equal to this one, or the next number: then the item is new.
    std::uint32_t number(const Item& item) {
        std::uint32_t* slot = &slot_of(item);
        if (*slot == 0) {
            if (2 * (items_.size() + 1) > slots_.size()) {
                resize(2 * slots_.size());
                for (std::uint32_t i = 0; i < items_.size(); ++i) {
                    slot_of(items_[i]) = i + 1;
                }
                slot = &slot_of(item);
            }
            items_.push_back(item);
            *slot = static_cast<std::uint32_t>(items_.size());
        }
        return *slot - 1;
    }

    /// By number.
    const std::vector<Item>& items() const noexcept { return items_; }

private:
    void resize(std::size_t slots) {
        slots_.assign(slots, 0);
        shift_ = 64 - std::countr_zero(slots);
    }

    /// The slot of the item, or the free one where it belongs.
    std::uint32_t& slot_of(const Item& item) {
        std::size_t slot = static_cast<std::size_t>(hash(item) >> shift_);
        while (slots_[slot] != 0 && !(items_[slots_[slot] - 1] == item)) {
            slot = (slot + 1) & (slots_.size() - 1);
        }
        return slots_[slot];
    }

    std::vector<Item> items_;
    std::vector<std::uint32_t> slots_;  ///< 1 + a number, or 0
    int shift_ = 0;
};

}  // namespace lamella
