// Lengths in mm as decimal text, short and at most half a grid unit off.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

namespace lamella {

/// Grid coordinates as decimal mm: enough digits to be within half a grid unit, or within 1e-6 mm where the grid is finer.
class MmFormat {
public:
    static constexpr int most_decimals = 6;
    static constexpr std::size_t most_chars = 24;

    explicit MmFormat(double unit_mm = std::numeric_limits<double>::min()) noexcept {
        double step = 1;
        while (step > unit_mm && decimals_ < most_decimals) {
            ++decimals_;
            ten_power_ *= 10;
            step = 1 / static_cast<double>(ten_power_);
        }
        scale_ = unit_mm * static_cast<double>(ten_power_);
    }

    char* write(char* to, std::int32_t grid_units) const noexcept { return fixed(to, scale_ * grid_units); }
    char* write_mm(char* to, double mm) const noexcept { return fixed(to, mm * static_cast<double>(ten_power_)); }
    std::string text_of_mm(double mm) const {
        char text[most_chars + 1];
        return {text, write_mm(text, mm)};
    }
    void append_to(std::string& text, std::int32_t grid_units) const {
        char number[most_chars + 1];
        text.append(number, write(number, grid_units));
    }
    /// How far a written number may lie from its own.
    double rounding_mm() const noexcept { return 0.5 / static_cast<double>(ten_power_); }

private:
    /// `scaled` / 10^decimals, without trailing zeros.
    char* fixed(char* to, double scaled) const noexcept {
        if (scaled < 0) {
            *to = '-';
        }
        const auto magnitude = static_cast<std::uint64_t>(std::llround(std::abs(scaled)));
        to += static_cast<int>(scaled < 0 && magnitude != 0);
        char* const limit = to + most_chars;
        char* end = std::to_chars(to, limit, magnitude / ten_power_).ptr;
        const std::uint64_t fraction = magnitude % ten_power_;
        if (fraction != 0) {
            // A leading one keeps the zeros after the point; the point then takes its place.
            char* const point = end;
            end = std::to_chars(point, limit, fraction + ten_power_).ptr;
            *point = '.';
            while (end[-1] == '0') {
                --end;
            }
        }
        return end;
    }

    std::uint64_t ten_power_ = 1;
    int decimals_ = 0;
    double scale_ = 1;
};

}  // namespace lamella
