// Time: wall time of stages, and ticks to split a fused phase's time by, of which only the ratios are used.
#pragma once

#include <chrono>
#include <cstdint>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace lamella {

using Clock = std::chrono::steady_clock;

/// About 7 ns; a call to the system's clock would be felt at three a layer.
inline std::uint64_t ticks() noexcept {
#if defined(__x86_64__)
    return __rdtsc();
#else
    return static_cast<std::uint64_t>(Clock::now().time_since_epoch().count());
#endif
}

inline double milliseconds_since(Clock::time_point start) noexcept {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace lamella
