// Pixels of three bytes, and the text on them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace lamella {

struct Colour {
    std::uint8_t red = 0;
    std::uint8_t green = 0;
    std::uint8_t blue = 0;
};

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

    int width() const noexcept { return width_; }
    int height() const noexcept { return height_; }
    const std::uint8_t* row(int y) const noexcept { return pixels_.data() + offset(0, y); }

    void fill(Rectangle rectangle, Colour colour) noexcept;

    /// Precondition of both: the pixel is on the canvas.
    bool has(int x, int y, Colour colour) const noexcept;
    /// Mixes a colour into one pixel: share 0 leaves it, 1 replaces it.
    void mix(int x, int y, Colour colour, double share) noexcept;

    /// One line, text_height(unit) pixels high; what the font lacks becomes a box.
    void write(int x, int y, std::string_view text, int unit, Colour colour) noexcept;

private:
    std::size_t offset(int x, int y) const noexcept {
        return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
    }

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
