#include "medical/picture/canvas.hpp"

#include <algorithm>
#include <cmath>

#include "medical/picture/font.hpp"

namespace lamella {

Canvas::Canvas(int width, int height, Colour background)
    : width_(width), height_(height), pixels_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    fill({0, 0, width, height}, background);
}

void Canvas::fill(Rectangle rectangle, Colour colour) noexcept {
    const int left = std::clamp(rectangle.x, 0, width_);
    const int right = std::clamp(rectangle.x + rectangle.width, left, width_);
    const int bottom = std::clamp(rectangle.y + rectangle.height, 0, height_);
    for (int y = std::clamp(rectangle.y, 0, height_); y < bottom; ++y) {
        std::uint8_t* to = pixels_.data() + offset(left, y);
        for (int x = left; x < right; ++x) {
            *to++ = colour.red;
            *to++ = colour.green;
            *to++ = colour.blue;
        }
    }
}

bool Canvas::has(int x, int y, Colour colour) const noexcept {
    const std::uint8_t* const pixel = pixels_.data() + offset(x, y);
    return pixel[0] == colour.red && pixel[1] == colour.green && pixel[2] == colour.blue;
}

void Canvas::mix(int x, int y, Colour colour, double share) noexcept {
    std::uint8_t* const to = pixels_.data() + offset(x, y);
    const auto mixed = [share](std::uint8_t from, std::uint8_t into) {
        return static_cast<std::uint8_t>(std::lround(from + share * (into - from)));
    };
    to[0] = mixed(to[0], colour.red);
    to[1] = mixed(to[1], colour.green);
    to[2] = mixed(to[2], colour.blue);
}

void Canvas::write(int x, int y, std::string_view text, int unit, Colour colour) noexcept {
    for (const char character : text) {
        const Glyph glyph = glyph_of(character);
        for (int row = 0; row < glyph_rows; ++row) {
            for (int column = 0; column < glyph_columns; ++column) {
                if (glyph.dot(row, column)) {
                    fill({x + column * unit, y + row * unit, unit, unit}, colour);
                }
            }
        }
        x += (glyph_columns + 1) * unit;
    }
}

int text_width(std::string_view text, int unit) noexcept {
    return text.empty() ? 0 : (static_cast<int>(std::min<std::size_t>(text.size(), 4096)) * (glyph_columns + 1) - 1) * unit;
}

}  // namespace lamella
