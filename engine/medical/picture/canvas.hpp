// Pixels of three bytes, the text on them, and the PNG file that they become.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "lamella/error.hpp"

namespace lamella {

/// Red, green, blue.
using Colour = std::array<std::uint8_t, 3>;

struct Rectangle {
    int x = 0;  ///< of the left side; pixels from the left and from the top
    int y = 0;
    int width = 0;
    int height = 0;
};

/// Rows from the top. What reaches beyond the canvas is cut off.
class Canvas {
public:
    /// Throws std::bad_alloc.
    Canvas(int width, int height, Colour background);

    void fill(Rectangle rectangle, Colour colour) noexcept;

    /// Precondition of both: the pixel is on the canvas.
    bool has(int x, int y, Colour colour) const noexcept;
    /// Mixes a colour into one pixel: share 0 leaves it, 1 replaces it.
    void mix(int x, int y, Colour colour, double share) noexcept;

    /// One line in a font of digits, letters and a few signs, text_height(unit) pixels high.
    void write(int x, int y, std::string_view text, int unit, Colour colour) noexcept;

    /// Equal pixels give equal bytes: no time is written. Precondition: can_write_pictures(). Throws Refused
    /// (unwritable_file), std::bad_alloc.
    Status write_png(const std::filesystem::path& path) const;

private:
    std::size_t offset(int x, int y) const noexcept {
        return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
    }
    std::uint8_t* pixel(int x, int y) noexcept { return pixels_.data() + offset(x, y); }

    int width_;
    int height_;
    std::vector<std::uint8_t> pixels_;
};

/// In pixels; `unit` is the side of one dot of the font.
int text_width(std::string_view text, int unit) noexcept;
inline int text_height(int unit) noexcept {
    return 7 * unit;
}

}  // namespace lamella
