// SplitMix64's finaliser: every bit of the result depends on every bit of the word, the same on every platform.
#pragma once

#include <cstdint>

namespace lamella {

inline std::uint64_t mixed(std::uint64_t word) noexcept {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9U;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBU;
    return word ^ (word >> 31);
}

}  // namespace lamella
