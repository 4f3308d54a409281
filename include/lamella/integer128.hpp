// A signed 128-bit integer in the public results: areas on the grid are exact, and compilers' own types are not portable.
#pragma once

#include <cstdint>

namespace lamella {

/// A signed 128-bit integer as two words, so that areas are exact and the layout is plain.
struct Integer128 {
    std::uint64_t low = 0;
    std::int64_t high = 0;
    /// By magnitude: the two words of a small negative number would cancel.
    double to_double() const noexcept {
        const bool negative = high < 0;
        const std::uint64_t magnitude_low = negative ? 0 - low : low;
        const std::uint64_t magnitude_high =
            (negative ? ~static_cast<std::uint64_t>(high) + (low == 0 ? 1U : 0U) : static_cast<std::uint64_t>(high));
        const double magnitude = static_cast<double>(magnitude_high) * 0x1p64 + static_cast<double>(magnitude_low);
        return negative ? -magnitude : magnitude;
    }
    friend bool operator==(const Integer128&, const Integer128&) = default;
};

}  // namespace lamella
