// Wall time of stages.
#pragma once

#include <chrono>

namespace lamella {

using Clock = std::chrono::steady_clock;

inline double milliseconds_since(Clock::time_point start) noexcept {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace lamella
