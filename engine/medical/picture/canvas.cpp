#include "medical/picture/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include "base/guard.hpp"
#include "io/write/output_file.hpp"
#include "lamella/medical/picture.hpp"

#ifdef LAMELLA_HAS_PNG
#include <png.h>
#endif

namespace lamella {

namespace {

constexpr std::size_t glyph_columns = 5;
constexpr std::size_t glyph_rows = 7;
constexpr int advance = 6;  ///< dots from a character to the next
constexpr std::size_t glyphs_a_band = 18;

constexpr std::string_view characters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz.,-+_/():";

// clang-format off
/// The characters in their order, side by side in bands of glyph_rows rows.
constexpr std::array<std::string_view, 28> dots = {
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
bool has_dot(char character, std::size_t row, std::size_t column) noexcept {
    if (character == ' ') {
        return false;
    }
    const std::size_t place = characters.find(character);
    if (place == std::string_view::npos) {
        return row % (glyph_rows - 1) == 0 || column % (glyph_columns - 1) == 0;
    }
    const std::string_view line = dots[place / glyphs_a_band * glyph_rows + row];
    return line[place % glyphs_a_band * (glyph_columns + 1) + column] == '#';
}

}  // namespace

Canvas::Canvas(int width, int height, Colour background)
    : width_(width), height_(height), pixels_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    fill({0, 0, width, height}, background);
}

void Canvas::fill(Rectangle rectangle, Colour colour) noexcept {
    const int left = std::clamp(rectangle.x, 0, width_);
    const int right = std::clamp(rectangle.x + rectangle.width, left, width_);
    const int bottom = std::clamp(rectangle.y + rectangle.height, 0, height_);
    for (int y = std::clamp(rectangle.y, 0, height_); y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
            std::copy(colour.begin(), colour.end(), pixel(x, y));
        }
    }
}

bool Canvas::has(int x, int y, Colour colour) const noexcept {
    return std::equal(colour.begin(), colour.end(), pixels_.data() + offset(x, y));
}

void Canvas::mix(int x, int y, Colour colour, double share) noexcept {
    std::uint8_t* to = pixel(x, y);
    for (const std::uint8_t into : colour) {
        *to = static_cast<std::uint8_t>(std::lround(*to + share * (into - *to)));
        ++to;
    }
}

void Canvas::write(int x, int y, std::string_view text, int unit, Colour colour) noexcept {
    for (const char character : text) {
        for (std::size_t row = 0; row < glyph_rows; ++row) {
            for (std::size_t column = 0; column < glyph_columns; ++column) {
                if (has_dot(character, row, column)) {
                    fill({x + static_cast<int>(column) * unit, y + static_cast<int>(row) * unit, unit, unit}, colour);
                }
            }
        }
        x += advance * unit;
    }
}

int text_width(std::string_view text, int unit) noexcept {
    return text.empty() ? 0 : (static_cast<int>(std::min<std::size_t>(text.size(), 4096)) * advance - 1) * unit;
}

#ifdef LAMELLA_HAS_PNG

bool can_write_pictures() noexcept {
    return true;
}

Status Canvas::write_png(const std::filesystem::path& path) const {
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
    return file.commit();
}

#else

bool can_write_pictures() noexcept {
    return false;
}

Status Canvas::write_png(const std::filesystem::path& path) const {
    return unwritable(path, ENOTSUP);
}

#endif

}  // namespace lamella
