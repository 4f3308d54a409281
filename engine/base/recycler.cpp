#include "base/recycler.hpp"

#include <cassert>
#include <new>
#include <utility>

#include "lamella/array.hpp"

namespace lamella {

namespace {

constexpr std::size_t unit_bytes = std::size_t{1} << 16;   ///< free blocks have a multiple of it
constexpr std::size_t least_bytes = std::size_t{1} << 20;  ///< smaller blocks are not recycled

constexpr std::size_t rounded(std::size_t bytes) {
    return (bytes + unit_bytes - 1) / unit_bytes * unit_bytes;
}

std::byte* end_of(void* block, std::size_t bytes) {
    return static_cast<std::byte*>(block) + bytes;
}

}  // namespace

Recycler::~Recycler() {
    for (const Taken& taken : taken_) {
        detail::give_memory(nullptr, taken.block, taken.bytes);
    }
}

/// The smallest that suffices, cut to size; null if there is none.
Recycler::Free* Recycler::take_fitting(std::size_t bytes) noexcept {
    Free** best = nullptr;
    for (Free** at = &first_; *at != nullptr; at = &(*at)->next) {
        if ((*at)->bytes >= bytes && (best == nullptr || (*at)->bytes < (*best)->bytes)) {
            best = at;
        }
    }
    if (best == nullptr) {
        return nullptr;
    }
    Free* const block = *best;
    if (block->bytes == bytes) {
        *best = block->next;
    } else {
        *best = new (end_of(block, bytes)) Free{block->bytes - bytes, block->next};
    }
    return block;
}

void* Recycler::allocate(std::size_t bytes, [[maybe_unused]] std::size_t alignment) {
    assert(alignment <= unit_bytes);
    if (bytes < least_bytes) {
        return detail::take_memory(nullptr, bytes);
    }
    const std::lock_guard lock(mutex_);
    if (void* const block = take_fitting(rounded(bytes)); block != nullptr) {
        return block;
    }
    taken_.reserve(taken_.size() + 1);
    void* const block = detail::take_memory(nullptr, rounded(bytes));
    taken_.push_back({block, rounded(bytes)});
    return block;
}

void Recycler::deallocate(void* block, std::size_t bytes, std::size_t) noexcept {
    if (bytes < least_bytes) {
        detail::give_memory(nullptr, block, bytes);
        return;
    }
    const std::lock_guard lock(mutex_);
    Free* before = nullptr;
    Free* after = first_;
    while (after != nullptr && after < block) {
        before = std::exchange(after, after->next);
    }
    auto* const freed = new (block) Free{rounded(bytes), after};
    (before == nullptr ? first_ : before->next) = freed;
    const auto join = [](Free* low, Free* high) {
        if (low != nullptr && high != nullptr && end_of(low, low->bytes) == reinterpret_cast<std::byte*>(high)) {
            low->bytes += high->bytes;
            low->next = high->next;
        }
    };
    join(freed, after);
    join(before, freed);
}

}  // namespace lamella
