// Digits, letters and a few signs, five dots wide and seven high.
#pragma once

#include <cstdint>

namespace lamella {

inline constexpr int glyph_columns = 5;
inline constexpr int glyph_rows = 7;

/// Bit 34 is the dot at the upper left, bit 0 that at the lower right.
struct Glyph {
    std::uint64_t dots = 0;
    bool dot(int row, int column) const noexcept {
        return (dots >> (glyph_columns * glyph_rows - 1 - row * glyph_columns - column) & 1) != 0;
    }
};

/// A character that the font lacks is a box.
Glyph glyph_of(char character) noexcept;

}  // namespace lamella
