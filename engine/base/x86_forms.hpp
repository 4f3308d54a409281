// Forms of hot kernels for x86 processors, taken at run time: the marks for their functions, and what the processor has.
#pragma once

#include <cstddef>

#if defined(__x86_64__) && defined(__GNUC__)
#define LAMELLA_X86_FORMS
#include <immintrin.h>

#define LAMELLA_AVX2 __attribute__((target("avx2")))
#define LAMELLA_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline
#define LAMELLA_AVX512 __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt")))
#define LAMELLA_AVX512_INLINE __attribute__((target("avx512f,avx512vl,avx512dq,avx2,popcnt"), always_inline)) inline
#endif

namespace lamella {

#ifdef LAMELLA_X86_FORMS
constexpr std::size_t lanes_of_512 = 16;  // of 32 bits
constexpr __mmask16 all_lanes = 0xFFFF;
#endif

inline bool has_avx2() noexcept {
#ifdef LAMELLA_X86_FORMS
    return __builtin_cpu_supports("avx2") != 0;
#else
    return false;
#endif
}

inline bool has_avx512() noexcept {
#ifdef LAMELLA_X86_FORMS
    return has_avx2() && __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
           __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("popcnt") != 0;
#else
    return false;
#endif
}

}  // namespace lamella
