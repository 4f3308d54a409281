// Exact 128-bit integers, signs, bits of numbers, and mixing of bits for hashes: the same on every platform.
#pragma once

#include <cstdint>
#include <type_traits>

#include "base/system/int128.hpp"
#include "lamella/integer128.hpp"

namespace lamella {

inline Integer128 to_integer128(Int128 value) noexcept {
    return {static_cast<std::uint64_t>(value), static_cast<std::int64_t>(value >> 64)};
}

inline Int128 to_int128(const Integer128& value) noexcept {
    return (Int128{value.high} << 64) | Int128{value.low};
}

/// The same bits as another type. std::bit_cast would be it, but libc++ 13, which emscripten 3.1 has, lacks it.
template <class To, class From>
constexpr To bits_as(const From& from) noexcept {
    static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To> && std::is_trivially_copyable_v<From>);
    return __builtin_bit_cast(To, from);
}

/// 1, 0 or -1; 0 of what is not a number.
template <class Number>
constexpr int sign_of(Number value) noexcept {
    return static_cast<int>(value > 0) - static_cast<int>(value < 0);
}

/// SplitMix64's finaliser: every bit of the result depends on every bit of the word.
inline std::uint64_t mix64(std::uint64_t word) noexcept {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9U;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBU;
    return word ^ (word >> 31);
}

/// The two halves of a product, folded: every bit depends on most bits of both factors. For where mix64() would take as long
/// as all else.
inline std::uint64_t mul_fold(std::uint64_t a, std::uint64_t b) noexcept {
    const Word128 product = Word128{a} * b;
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

}  // namespace lamella
