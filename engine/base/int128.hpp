// 128-bit integers: areas and orientations are exact.
#pragma once

#include "lamella/integer128.hpp"

namespace lamella {

__extension__ using Int128 = __int128;

inline Integer128 to_integer128(Int128 value) noexcept {
    return {static_cast<std::uint64_t>(value), static_cast<std::int64_t>(value >> 64)};
}

inline Int128 to_int128(const Integer128& value) noexcept {
    return (Int128{value.high} << 64) | Int128{value.low};
}

}  // namespace lamella
