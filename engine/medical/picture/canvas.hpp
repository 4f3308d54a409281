// Pixels of three bytes, the text on them, the PNG file that they become; and where on them cells, names and the scale lie.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "lamella/medical/picture.hpp"

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

namespace colours {
inline constexpr Colour page{0xff, 0xff, 0xff};
inline constexpr Colour cell{0xf1, 0xf3, 0xf5};
inline constexpr Colour text{0x2b, 0x30, 0x36};
inline constexpr Colour open{0xd8, 0x1b, 0x1b};
}  // namespace colours

/// In mm, in the frame of the slicing; empty at first.
struct BoxMm {
    PointMm min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    PointMm max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    double width() const noexcept { return max.x - min.x; }
    double height() const noexcept { return max.y - min.y; }
    void widen(PointMm at) noexcept {
        min = {std::min(min.x, at.x), std::min(min.y, at.y)};
        max = {std::max(max.x, at.x), std::max(max.y, at.y)};
    }
};

/// Colours repeat after twelve parts.
inline Colour colour_of_part(std::size_t part) noexcept {
    // clang-format off
    static constexpr std::array<Colour, 12> palette = {{
        {0x1f, 0x6f, 0xb4}, {0xf2, 0x8e, 0x2b}, {0x2a, 0x9d, 0x5c}, {0x8e, 0x5b, 0xb5}, {0xe5, 0xb8, 0x13}, {0x17, 0xa2, 0xb8},
        {0xe3, 0x77, 0xa8}, {0x8c, 0x62, 0x45}, {0x9a, 0xb9, 0x3a}, {0x3d, 0x48, 0x9c}, {0x7a, 0x86, 0x92}, {0x0b, 0x5d, 0x4e}}};
    // clang-format on
    return palette[part % palette.size()];
}

/// With so many decimals, without a sign where it rounds to zero.
inline std::string decimal_text(double value, int decimals) {
    std::array<char, 400> text{};
    const auto [end, error] =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
    std::string all(text.data(), end);
    return all.find_first_not_of("-0.") == std::string::npos && all.front() == '-' ? all.substr(1) : all;
}

/// Cells of one size in rows, below a line with names and scale.
class Page {
public:
    /// Chooses the number of columns that gives the largest scale. `label_width`: of the widest label, in dots of the font.
    /// Throws Refused where the cells would be too small.
    Page(const BoxMm& box, std::size_t cells, int label_width, const PictureOptions& options) {
        unit_ = std::max(1, std::min(options.width, options.height) / 600);
        gap_ = 4 * unit_;
        heading_height_ = text_height(unit_) + 2 * gap_;
        const int label_height = text_height(unit_) + gap_;
        const auto count = static_cast<int>(cells);
        int rows = 1;
        int most_width = 0;
        int most_height = 0;
        for (int columns = 1; columns <= count; ++columns) {
            const int rows_then = (count + columns - 1) / columns;
            const int width = (options.width - gap_ * (columns + 1)) / columns;
            const int height = (options.height - heading_height_ - gap_ * rows_then) / rows_then;
            const double scale =
                std::min((width - 2 * gap_) / box.width(), (height - label_height - 2 * gap_) / box.height());
            if (columns == 1 || scale > pixels_per_mm_) {
                pixels_per_mm_ = scale;
                columns_ = columns;
                rows = rows_then;
                most_width = width;
                most_height = height;
            }
        }
        constexpr int least_pixels = 16;  // the narrowest that still shows something
        if (!(pixels_per_mm_ * std::max(box.width(), box.height()) >= least_pixels)) {
            throw Refused{{ErrorCode::invalid_argument, "a picture of " + std::to_string(options.width) + " x " +
                                                            std::to_string(options.height) + " pixels has no room for " +
                                                            counted(cells, "layer")}};
        }
        const auto around = [&](double mm) { return static_cast<int>(std::ceil(mm * pixels_per_mm_)) + 2 * gap_; };
        cell_width_ = std::min(most_width, std::max(around(box.width()), label_width * unit_ + 2 * gap_));
        cell_height_ = std::min(most_height, around(box.height()) + label_height);
        // A few narrow cells leave room for the names.
        width_ = std::max(gap_ + columns_ * (cell_width_ + gap_), std::min(options.width, 200 * unit_));
        height_ = heading_height_ + rows * (cell_height_ + gap_);
    }

    int unit() const noexcept { return unit_; }  ///< pixels of a dot of the font
    int width() const noexcept { return width_; }
    int height() const noexcept { return height_; }
    double pixels_per_mm() const noexcept { return pixels_per_mm_; }

    /// Draws a cell and its label. Returns the part of it that the layer is drawn into.
    Rectangle draw_cell(Canvas& canvas, std::size_t i, const std::string& label) const {
        const int column = static_cast<int>(i) % columns_;
        const int row = static_cast<int>(i) / columns_;
        const int x = gap_ + column * (cell_width_ + gap_);
        const int y = heading_height_ + row * (cell_height_ + gap_);
        canvas.fill({x, y, cell_width_, cell_height_}, colours::cell);
        canvas.write(x + gap_, y + gap_, label, unit_, colours::text);
        const int label_height = gap_ + text_height(unit_);
        return {x + 1, y + label_height, cell_width_ - 2, cell_height_ - label_height - 1};
    }

    /// One line: a coloured square and the name of each part as far as they go, how many layers have open polylines
    /// if any, and a bar of a round length.
    void draw_heading(Canvas& canvas, std::span<const PicturePart> parts, std::uint64_t open_layers) const {
        const int end = draw_scale(canvas) - gap_;
        const int square = text_height(unit_);
        int x = gap_;
        // Returns whether there was room.
        const auto entry = [&](std::string_view name, Colour colour, int mark_height, int left_over) {
            const int width = square + 2 * unit_ + text_width(name, unit_) + 2 * gap_;
            if (x + width + left_over > end) {
                return false;
            }
            canvas.fill({x, gap_ + (square - mark_height) / 2, square, mark_height}, colour);
            canvas.write(x + square + 2 * unit_, gap_, name, unit_, colours::text);
            x += width;
            return true;
        };
        if (open_layers > 0) {
            entry("open in " + counted(open_layers, "layer"), colours::open, 2 * unit_, 0);
        }
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const std::string rest = "+" + std::to_string(parts.size() - i);
            const int left_over = i + 1 < parts.size() ? text_width(rest, unit_) : 0;
            if (!entry(parts[i].name, colour_of_part(i), square, left_over)) {
                if (x + text_width(rest, unit_) <= end) {
                    canvas.write(x, gap_, rest, unit_, colours::text);
                }
                return;
            }
        }
    }

private:
    /// A bar of 1, 2, 5, 10, 20, ... mm, as long as there is room. Returns where it begins.
    int draw_scale(Canvas& canvas) const {
        const double most_mm = std::min(0.5 * cell_width_, 0.25 * width_) / pixels_per_mm_;
        const double exponent = std::floor(std::log10(most_mm));
        const double step = std::pow(10, exponent);
        const double length_mm = step * (5 * step <= most_mm ? 5 : 2 * step <= most_mm ? 2 : 1);
        const std::string text = decimal_text(length_mm, static_cast<int>(std::clamp(-exponent, 0.0, 9.0))) + " mm";
        const int length = std::max(1, static_cast<int>(std::lround(length_mm * pixels_per_mm_)));
        const int right = width_ - gap_ - text_width(text, unit_);
        const int left = right - 2 * unit_ - length;
        const int middle = gap_ + text_height(unit_) / 2;
        canvas.write(right, gap_, text, unit_, colours::text);
        canvas.fill({left, middle - unit_ / 2, length, unit_}, colours::text);
        for (const int end : {left, left + length - unit_}) {
            canvas.fill({end, middle - 2 * unit_, unit_, 4 * unit_}, colours::text);
        }
        return left;
    }

    int unit_ = 1;
    int gap_ = 0;
    int heading_height_ = 0;
    int columns_ = 1;
    int cell_width_ = 0;
    int cell_height_ = 0;
    int width_ = 0;
    int height_ = 0;
    double pixels_per_mm_ = 0;
};

}  // namespace lamella
