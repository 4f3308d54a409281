#include "slicing/nesting/order.hpp"

#include <bit>
#include <iterator>
#include <numeric>

namespace lamella::nesting {

namespace {

/// The smallest upper half and the smallest lower half. Keys minus this have few digits, wherever the layer lies.
std::uint64_t smallest_halves(const Vector<SortKey>& keys) noexcept {
    std::uint64_t upper = keys[0].key >> 32;
    auto lower = static_cast<std::uint32_t>(keys[0].key);
    for (const SortKey& key : keys) {
        upper = std::min(upper, key.key >> 32);
        lower = std::min(lower, static_cast<std::uint32_t>(key.key));
    }
    return upper << 32 | lower;
}

/// Stable sort by one digit of key - base, `shift` bits up.
template <int digit_bits>
void sort_by_digit(Vector<SortKey>& keys, Vector<SortKey>& spare, std::uint64_t base, int shift) {
    constexpr std::uint64_t mask = (1U << digit_bits) - 1;
    std::uint32_t ends[mask + 1] = {};
    for (const SortKey& key : keys) {
        ++ends[(key.key - base) >> shift & mask];
    }
    std::exclusive_scan(std::begin(ends), std::end(ends), std::begin(ends), 0U);
    spare.resize(keys.size());
    for (const SortKey& key : keys) {
        spare[ends[(key.key - base) >> shift & mask]++] = key;
    }
    keys.swap(spare);
}

/// For nearly sorted keys; others are sorted as any.
void insert_in_order(Vector<SortKey>& keys) {
    std::size_t moves_left = 4 * keys.size();
    for (std::size_t i = 1; i < keys.size(); ++i) {
        const SortKey key = keys[i];
        std::size_t place = i;
        for (; place > 0 && before(key, keys[place - 1]); --place) {
            keys[place] = keys[place - 1];
        }
        keys[place] = key;
        if (i - place > moves_left) {
            sort_briefly(keys.begin(), keys.end(), before);
            return;
        }
        moves_left -= i - place;
    }
}

}  // namespace

/// Few are spread by the highest digit that varies, which leaves them nearly sorted. Many are sorted digit by digit from the
/// lowest up; constant digits are skipped.
void sort_keys(Vector<SortKey>& keys, Vector<SortKey>& spare, StopPace& pace) {
    constexpr std::size_t very_few = 24;
    constexpr std::size_t few = 1024;
    constexpr int digit_bits = 11;
    if (std::is_sorted(keys.begin(), keys.end(), before)) {
        return;
    }
    if (keys.size() <= very_few) {
        sort_briefly(keys.begin(), keys.end(), before);
        return;
    }
    const std::uint64_t base = smallest_halves(keys);
    std::uint64_t varying = 0;
    for (const SortKey& key : keys) {
        varying |= key.key - base;
    }
    if (keys.size() < few) {
        constexpr int bits = 9;
        sort_by_digit<bits>(keys, spare, base, std::max(0, static_cast<int>(std::bit_width(varying)) - bits));
        insert_in_order(keys);
        return;
    }
    for (int shift = 0; shift < 64 && varying >> shift != 0; shift += digit_bits) {
        shift += std::countr_zero(varying >> shift);
        sort_by_digit<digit_bits>(keys, spare, base, shift);
        pace.spend(keys.size());
    }
}

}  // namespace lamella::nesting
