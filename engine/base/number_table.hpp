// Numbers for items that are kept elsewhere, found again by the items' hashes: open addressing, at most half full.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lamella {

/// Items get the numbers 0, 1, 2, ... in the order in which they come. Slots are taken by the highest bits of hashes.
class NumberTable {
public:
    /// Forgets all items, and makes room for `count`; beyond that it grows. Memory is kept.
    void clear(std::size_t count) {
        count_ = 0;
        resize(std::bit_ceil(2 * count + 2));
    }

    /// The number of the item for which is_same(number) holds, among those of this hash, or the next number: then the item
    /// is new. hash_of(number) is the hash of an item that came before.
    template <class IsSame, class HashOf>
    std::uint32_t number(std::uint64_t hash, const IsSame& is_same, const HashOf& hash_of) {
        std::uint32_t* slot = &find(hash, is_same);
        if (*slot == 0) {
            if (2 * (std::size_t{count_} + 1) > slots_.size()) {
                resize(2 * slots_.size());
                for (std::uint32_t i = 0; i < count_; ++i) {
                    find(hash_of(i), [](std::uint32_t) { return false; }) = i + 1;
                }
                slot = &find(hash, is_same);
            }
            *slot = ++count_;
        }
        return *slot - 1;
    }

private:
    void resize(std::size_t slots) {
        slots_.assign(slots, 0);
        shift_ = 64 - std::countr_zero(slots);
    }

    /// The slot of the item, or the free one where it belongs.
    template <class IsSame>
    std::uint32_t& find(std::uint64_t hash, const IsSame& is_same) {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = static_cast<std::size_t>(hash >> shift_);
        while (slots_[slot] != 0 && !is_same(slots_[slot] - 1)) {
            slot = (slot + 1) & mask;
        }
        return slots_[slot];
    }

    std::vector<std::uint32_t> slots_;  ///< 1 + a number, or 0
    int shift_ = 0;
    std::uint32_t count_ = 0;
};

}  // namespace lamella
