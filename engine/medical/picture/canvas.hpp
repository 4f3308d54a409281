// Pixels of three bytes, the text on them, and the PNG file that they become.
#pragma once

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <new>
#include <string_view>
#include <vector>

#ifdef LAMELLA_HAS_PNG
#include <png.h>
#endif

#include "base/guard.hpp"
#include "io/write/output_file.hpp"

namespace lamella {

namespace font {

inline constexpr std::size_t columns = 5;
inline constexpr std::size_t rows = 7;
inline constexpr int advance = 6;  ///< dots from a character to the next
inline constexpr std::size_t glyphs_a_band = 18;
inline constexpr std::string_view characters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz.,-+_/():";

// clang-format off
/// The characters in their order, side by side in bands of rows rows.
inline constexpr std::array<std::string_view, 28> dots = {
    // 0     1     2     3     4     5     6     7     8     9     A     B     C     D     E     F     G     H
    ".###. ..#.. .###. .###. ...#. ##### ..##. ##### .###. .###. .###. ####. .###. ####. ##### ##### .###. #...#",
    "#...# .##.. #...# #...# ..##. #.... .#... ....# #...# #...# #...# #...# #...# #...# #.... #.... #...# #...#",
    "#..## ..#.. ....# ....# .#.#. ####. #.... ...#. #...# #...# #...# #...# #.... #...# #.... #.... #.... #...#",
    "#.#.# ..#.. ...#. ..##. #..#. ....# ####. ..#.. .###. .#### ##### ####. #.... #...# ####. ####. #.### #####",
    "##..# ..#.. ..#.. ....# ##### ....# #...# .#... #...# ....# #...# #...# #.... #...# #.... #.... #...# #...#",
    "#...# ..#.. .#... #...# ...#. #...# #...# .#... #...# ...#. #...# #...# #...# #...# #.... #.... #...# #...#",
    ".###. .###. ##### .###. ...#. .###. .###. .#... .###. .##.. #...# ####. .###. ####. ##### #.... .#### #...#",
    // I     J     K     L     M     N     O     P     Q     R     S     T     U     V     W     X     Y     Z
    ".###. ..### #...# #.... #...# #...# .###. ####. .###. ####. .#### ##### #...# #...# #...# #...# #...# #####",
    "..#.. ...#. #..#. #.... ##.## ##..# #...# #...# #...# #...# #.... ..#.. #...# #...# #...# #...# #...# ....#",
    "..#.. ...#. #.#.. #.... #.#.# #.#.# #...# #...# #...# #...# #.... ..#.. #...# #...# #...# .#.#. .#.#. ...#.",
    "..#.. ...#. ##... #.... #.#.# #..## #...# ####. #...# ####. .###. ..#.. #...# #...# #.#.# ..#.. ..#.. ..#..",
    "..#.. ...#. #.#.. #.... #...# #...# #...# #.... #.#.# #.#.. ....# ..#.. #...# #...# #.#.# .#.#. ..#.. .#...",
    "..#.. #..#. #..#. #.... #...# #...# #...# #.... #..#. #..#. ....# ..#.. #...# .#.#. ##.## #...# ..#.. #....",
    ".###. .##.. #...# ##### #...# #...# .###. #.... .##.# #...# ####. ..#.. .###. ..#.. #...# #...# ..#.. #####",
    // a     b     c     d     e     f     g     h     i     j     k     l     m     n     o     p     q     r
    "..... #.... ..... ....# ..... ..##. ..... #.... ..#.. ...#. #.... .##.. ..... ..... ..... ..... ..... .....",
    "..... #.... ..... ....# ..... .#..# .#### #.... ..... ..... #.... ..#.. ..... ..... ..... ..... ..... .....",
    ".###. #.##. .###. .##.# .###. .#... #...# #.##. .##.. ..##. #..#. ..#.. ##.#. #.##. .###. ####. .##.# #.##.",
    "....# ##..# #.... #..## #...# ###.. #...# ##..# ..#.. ...#. #.#.. ..#.. #.#.# ##..# #...# #...# #..## ##..#",
    ".#### #...# #.... #...# ##### .#... .#### #...# ..#.. ...#. ##... ..#.. #.#.# #...# #...# ####. .#### #....",
    "#...# #...# #...# #...# #.... .#... ....# #...# ..#.. #..#. #.#.. ..#.. #.#.# #...# #...# #.... ....# #....",
    ".#### ####. .###. .#### .###. .#... .###. #...# .###. .##.. #..#. .###. #.#.# #...# .###. #.... ....# #....",
    // s     t     u     v     w     x     y     z     .     ,     -     +     _     /     (     )     :
    "..... .#... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..... ....# ...#. .#... .....",
    "..... .#... ..... ..... ..... ..... ..... ..... ..... ..... ..... ..#.. ..... ....# ..#.. ..#.. .##..",
    ".###. ###.. #...# #...# #...# #...# #...# ##### ..... ..... ..... ..#.. ..... ...#. .#... ...#. .##..",
    "#.... .#... #...# #...# #...# .#.#. #...# ...#. ..... ..... ##### ##### ..... ..#.. .#... ...#. .....",
    ".###. .#... #...# #...# #.#.# ..#.. .#### ..#.. ..... .##.. ..... ..#.. ..... .#... .#... ...#. .##..",
    "....# .#..# #..## .#.#. #.#.# .#.#. ....# .#... .##.. ..#.. ..... ..#.. ..... #.... ..#.. ..#.. .##..",
    "####. ..##. .##.# ..#.. .#.#. #...# .###. ##### .##.. .#... ..... ..... ##### #.... ...#. .#... .....",
};
// clang-format on

/// A character that the font lacks is a box.
inline bool has_dot(char character, std::size_t row, std::size_t column) noexcept {
    if (character == ' ') {
        return false;
    }
    const std::size_t place = characters.find(character);
    if (place == std::string_view::npos) {
        return row % (rows - 1) == 0 || column % (columns - 1) == 0;
    }
    const std::string_view line = dots[place / glyphs_a_band * rows + row];
    return line[place % glyphs_a_band * (columns + 1) + column] == '#';
}

}  // namespace font

/// In pixels; `unit` is the side of one dot of the font.
inline int text_width(std::string_view text, int unit) noexcept {
    return text.empty() ? 0 : (static_cast<int>(std::min<std::size_t>(text.size(), 4096)) * font::advance - 1) * unit;
}
inline int text_height(int unit) noexcept {
    return static_cast<int>(font::rows) * unit;
}

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
    Canvas(int width, int height, Colour background)
        : width_(width), height_(height), pixels_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
        fill({0, 0, width, height}, background);
    }

    void fill(Rectangle rectangle, Colour colour) noexcept {
        const int left = std::clamp(rectangle.x, 0, width_);
        const int right = std::clamp(rectangle.x + rectangle.width, left, width_);
        const int bottom = std::clamp(rectangle.y + rectangle.height, 0, height_);
        for (int y = std::clamp(rectangle.y, 0, height_); y < bottom; ++y) {
            for (int x = left; x < right; ++x) {
                std::copy(colour.begin(), colour.end(), pixel(x, y));
            }
        }
    }

    /// Mixes a colour into one pixel, which is on the canvas: share 0 leaves it, 1 replaces it. `over`: what the share is
    /// multiplied by where the pixel is not of the colour `ground`.
    void mix(int x, int y, Colour colour, double share, Colour ground, double over) noexcept {
        std::uint8_t* to = pixel(x, y);
        share *= std::equal(ground.begin(), ground.end(), to) ? 1 : over;
        for (const std::uint8_t into : colour) {
            *to = static_cast<std::uint8_t>(std::lround(*to + share * (into - *to)));
            ++to;
        }
    }

    /// One line in a font of digits, letters and a few signs, text_height(unit) pixels high.
    void write(int x, int y, std::string_view text, int unit, Colour colour) noexcept {
        for (const char character : text) {
            for (std::size_t row = 0; row < font::rows; ++row) {
                for (std::size_t column = 0; column < font::columns; ++column) {
                    if (font::has_dot(character, row, column)) {
                        fill({x + static_cast<int>(column) * unit, y + static_cast<int>(row) * unit, unit, unit}, colour);
                    }
                }
            }
            x += font::advance * unit;
        }
    }

#ifdef LAMELLA_HAS_PNG
    /// Equal pixels give equal bytes: no time is written. Throws Refused (unwritable_file), std::bad_alloc.
    void write_png(const std::filesystem::path& path) const {
        OutputFile file = require(OutputFile::create(path));
        png_image image{};
        image.version = PNG_IMAGE_VERSION;
        image.width = static_cast<png_uint_32>(width_);
        image.height = static_cast<png_uint_32>(height_);
        image.format = PNG_FORMAT_RGB;
        png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(image);
        std::vector<char> encoded(bytes);
        if (png_image_write_to_memory(&image, encoded.data(), &bytes, 0, pixels_.data(), 0, nullptr) == 0) {
            throw std::bad_alloc();  // the only way to fail
        }
        file.append({encoded.data(), bytes});
        require(file.commit());
    }
#else
    void write_png(const std::filesystem::path& path) const {
        throw Refused{unwritable(path, ENOTSUP)};
    }
#endif

private:
    std::uint8_t* pixel(int x, int y) noexcept {
        return pixels_.data() +
               3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x));
    }

    int width_;
    int height_;
    std::vector<std::uint8_t> pixels_;
};

}  // namespace lamella
