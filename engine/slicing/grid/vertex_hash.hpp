// A hash of a grid vertex, the same on every platform.
#pragma once

#include <cstdint>

#include "base/mixed.hpp"
#include "slicing/grid/quantise.hpp"

namespace lamella {

inline std::uint64_t hash_of(const GridVertex& v) noexcept {
    const std::uint64_t xy = std::uint64_t{static_cast<std::uint32_t>(v.x)} << 32 | static_cast<std::uint32_t>(v.y);
    return mixed(mixed(xy + 0x9E3779B97F4A7C15U) + static_cast<std::uint32_t>(v.z));
}

}  // namespace lamella
