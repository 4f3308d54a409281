// Rounding to nearest, ties to even, as one instruction. std::nearbyint without SSE4.1 is a library call, measured at a
// quarter of the sweep.
#pragma once

#include <cmath>
#include <cstdint>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace lamella {

/// Precondition: the rounded value fits 32 bits.
inline std::int32_t round_to_int(double value) noexcept {
#ifdef __SSE2__
    return _mm_cvtsd_si32(_mm_set_sd(value));
#else
    return static_cast<std::int32_t>(std::nearbyint(value));
#endif
}

}  // namespace lamella
