// Comparisons of sixteen coordinates at a time, by instructions that every x86-64 processor has.
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace lamella::nesting {

inline constexpr std::uint32_t lanes = 16;

/// Bit i: low < values[i] < high, for sixteen values.
inline unsigned between(const std::int32_t* values, std::int32_t low, std::int32_t high) noexcept {
#if defined(__SSE2__)
    const __m128i lows = _mm_set1_epi32(low);
    const __m128i highs = _mm_set1_epi32(high);
    const auto four = [&](int i) {
        const __m128i value = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values + i));
        return _mm_and_si128(_mm_cmpgt_epi32(value, lows), _mm_cmpgt_epi32(highs, value));
    };
    const __m128i eight = _mm_packs_epi32(four(0), four(4));
    return static_cast<unsigned>(_mm_movemask_epi8(_mm_packs_epi16(eight, _mm_packs_epi32(four(8), four(12)))));
#else
    unsigned bits = 0;
    for (int i = 0; i < static_cast<int>(lanes); ++i) {
        bits |= static_cast<unsigned>(low < values[i] && values[i] < high) << i;
    }
    return bits;
#endif
}

}  // namespace lamella::nesting
