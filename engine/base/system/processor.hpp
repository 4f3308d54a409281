// The processor's own instructions where it has them, else portable forms that give the same numbers. LAMELLA_PORTABLE, an
// option of the build, takes the portable forms everywhere.
#pragma once

#include <chrono>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

#if defined(__SSE2__) && !defined(LAMELLA_PORTABLE)
#define LAMELLA_SSE2
#include <emmintrin.h>
#endif
#if defined(__x86_64__) && defined(__GNUC__)
#include <cpuid.h>
#include <x86intrin.h>
#undef __cpuid  // a function of Windows' <intrin.h>
#endif

namespace lamella {

#if defined(__x86_64__) && defined(__GNUC__)
/// True if the processor has these bits of CPUID's leaf 7, and the system keeps these registers (bits of XCR0). A virtual
/// machine may take 50 us to answer. Not by __builtin_cpu_supports(), which some compilers' libraries lack.
inline bool has_vectors(unsigned features, unsigned registers) noexcept {
    unsigned a = 0, b = 0, c = 0, d = 0, kept = 0;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0 || (c & bit_OSXSAVE) == 0 || (c & bit_POPCNT) == 0) {
        return false;
    }
    __asm__("xgetbv" : "=a"(kept), "=d"(d) : "c"(0));
    return (kept & registers) == registers && __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b & features) == features;
}
#endif

/// To split a fused phase's time by: only the ratios are used. About 7 ns; a call to the system's clock would be felt at
/// three a layer.
inline std::uint64_t ticks() noexcept {
#if defined(__x86_64__) && !defined(LAMELLA_PORTABLE)
    return __rdtsc();
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

/// To nearest, ties to even, as one instruction: std::nearbyint without SSE4.1 is a library call, measured at a quarter of
/// the sweep. Precondition: the rounded value fits 32 bits.
inline std::int32_t round_to_int(double value) noexcept {
#ifdef LAMELLA_SSE2
    return _mm_cvtsd_si32(_mm_set_sd(value));
#else
    return static_cast<std::int32_t>(std::nearbyint(value));
#endif
}

/// The first byte becomes the last.
template <std::unsigned_integral Word>
constexpr Word reversed_bytes(Word word) noexcept {
    constexpr auto odd_bytes = static_cast<Word>(0x00FF00FF00FF00FF);
    constexpr auto odd_pairs = static_cast<Word>(0x0000FFFF0000FFFF);
    if constexpr (sizeof(Word) >= 2) {
        word = static_cast<Word>((word >> 8 & odd_bytes) | (word & odd_bytes) << 8);
    }
    if constexpr (sizeof(Word) >= 4) {
        word = (word >> 16 & odd_pairs) | (word & odd_pairs) << 16;
    }
    if constexpr (sizeof(Word) >= 8) {
        word = word >> 32 | word << 32;
    }
    return word;
}

/// A page loads the code that it runs: one form of a loop serves where two are a little faster.
#ifdef __EMSCRIPTEN__
inline constexpr bool small_code = true;
#else
inline constexpr bool small_code = false;
#endif

// Asks for what is read or written soon, which need not exist.
#if defined(__GNUC__) && !defined(LAMELLA_PORTABLE)
inline void prefetch_to_read(const void* at) noexcept {
    __builtin_prefetch(at);
}
inline void prefetch_to_write(const void* at) noexcept {
    __builtin_prefetch(at, 1);
}
#else
inline void prefetch_to_read(const void* /*at*/) noexcept {}
inline void prefetch_to_write(const void* /*at*/) noexcept {}
#endif

/// How far ahead of streams that the processor's own prefetchers do not keep up with: measured, and flat from 4 KiB on.
inline constexpr std::size_t prefetch_bytes = 4096;

/// Asks for [at + prefetch_bytes, at + prefetch_bytes + bytes). Which function asks is no argument: GCC drops such calls.
template <bool to_write = false>
void prefetch_ahead(const std::byte* at, std::size_t bytes) noexcept {
    constexpr std::size_t cache_line = 64;
    for (std::size_t offset = prefetch_bytes; offset < prefetch_bytes + bytes; offset += cache_line) {
        to_write ? prefetch_to_write(at + offset) : prefetch_to_read(at + offset);
    }
}

}  // namespace lamella
