// Stretches of walking order on their way to the next plane's.
#pragma once

#include <cstdint>
#include <cstring>

#include "slicing/contours/slot_table.hpp"

namespace lamella {

/// Room beyond the order's end that copy_run() may write and read.
inline constexpr std::size_t run_padding = 16;

/// Copies 64 bytes a step and writes beyond the end: most runs are short, and an exact length mispredicts.
inline void copy_run(const Slot* run, std::uint32_t length, Slot* to) {
    for (std::uint32_t i = 0; i < length; i += run_padding) {
        std::memcpy(to + i, run + i, run_padding * sizeof(Slot));
    }
}

/// positions[run[i]] = first + i.
inline void number_run(const Slot* run, std::uint32_t length, std::uint32_t first, std::uint32_t* positions) {
    std::uint32_t i = 0;
    for (; i + 4 <= length; i += 4) {
        positions[run[i]] = first + i;
        positions[run[i + 1]] = first + i + 1;
        positions[run[i + 2]] = first + i + 2;
        positions[run[i + 3]] = first + i + 3;
    }
    for (; i < length; ++i) {
        positions[run[i]] = first + i;
    }
}

}  // namespace lamella
