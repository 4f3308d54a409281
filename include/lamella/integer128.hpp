// A signed 128-bit integer, which holds the exact area of a contour.
//
//     const lamella::Integer128 twice_area = result.contours[0].twice_area;  // square grid units
//     const double mm2 = twice_area.to_double() / 2 * result.info.grid_mm * result.info.grid_mm;
//     std::printf("%g mm2\n", mm2);
//
// Compilers have such a type of their own, but it is not portable.
#pragma once

#include <cstdint>

namespace lamella {

/// high * 2^64 + low.
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
