// Where on a picture the cells, the names and the scale lie.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "base/guard.hpp"
#include "lamella/medical/picture.hpp"
#include "medical/picture/canvas.hpp"

namespace lamella {

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
        int rows = 1;
        for (int columns = 1; columns <= static_cast<int>(cells); ++columns) {
            const int rows_then =
                static_cast<int>((cells + static_cast<std::size_t>(columns) - 1) / static_cast<std::size_t>(columns));
            const double scale = scale_with(box, columns, rows_then, options);
            if (columns == 1 || scale > pixels_per_mm_) {
                pixels_per_mm_ = scale;
                columns_ = columns;
                rows = rows_then;
            }
        }
        const double larger = pixels_per_mm_ * std::max(box.width(), box.height());
        if (!(larger >= least_area_pixels)) {
            throw Refused{{ErrorCode::invalid_argument, "a picture of " + std::to_string(options.width) + " x " +
                                                            std::to_string(options.height) + " pixels has no room for " +
                                                            std::to_string(cells) + (cells == 1 ? " layer" : " layers")}};
        }
        const auto around = [&](double mm) { return static_cast<int>(std::ceil(mm * pixels_per_mm_)) + 2 * gap(); };
        const int most_width = (options.width - gap() * (columns_ + 1)) / columns_;
        cell_width_ = std::min(most_width, std::max(around(box.width()), label_width * unit_ + 2 * gap()));
        const int most_height = (options.height - heading_height() - gap() * rows) / rows;
        cell_height_ = std::min(most_height, around(box.height()) + label_height());
        // A few narrow cells leave room for the names.
        width_ = std::max(gap() + columns_ * (cell_width_ + gap()), std::min(options.width, 200 * unit_));
        height_ = heading_height() + rows * (cell_height_ + gap());
    }

    int unit() const noexcept { return unit_; }  ///< pixels of a dot of the font
    int width() const noexcept { return width_; }
    int height() const noexcept { return height_; }
    double pixels_per_mm() const noexcept { return pixels_per_mm_; }
    /// The part of a cell that the layer is drawn into.
    Rectangle area(std::size_t i) const noexcept {
        const Rectangle whole = cell(i);
        return {whole.x + 1, whole.y + label_height(), whole.width - 2, whole.height - label_height() - 1};
    }

    /// One line: a coloured square and the name of each part as far as they go, how many layers have open polylines
    /// if any, and a bar of a round length.
    void draw_heading(Canvas& canvas, const std::vector<std::string>& names, std::uint64_t open_layers) const {
        const int end = draw_scale(canvas) - gap();
        const int square = text_height(unit_);
        int x = gap();
        // Returns whether there was room.
        const auto entry = [&](std::string_view name, Colour colour, int mark_height, int left_over) {
            const int width = square + 2 * unit_ + text_width(name, unit_) + 2 * gap();
            if (x + width + left_over > end) {
                return false;
            }
            canvas.fill({x, gap() + (square - mark_height) / 2, square, mark_height}, colour);
            canvas.write(x + square + 2 * unit_, gap(), name, unit_, colours::text);
            x += width;
            return true;
        };
        if (open_layers > 0) {
            entry("open in " + std::to_string(open_layers) + (open_layers == 1 ? " layer" : " layers"), colours::open,
                  2 * unit_, 0);
        }
        for (std::size_t i = 0; i < names.size(); ++i) {
            const std::string rest = "+" + std::to_string(names.size() - i);
            const int left_over = i + 1 < names.size() ? text_width(rest, unit_) : 0;
            if (!entry(names[i], colour_of_part(i), square, left_over)) {
                if (x + text_width(rest, unit_) <= end) {
                    canvas.write(x, gap(), rest, unit_, colours::text);
                }
                return;
            }
        }
    }

    /// A cell without its layer.
    void draw_cell(Canvas& canvas, std::size_t i, const std::string& label) const {
        const Rectangle whole = cell(i);
        canvas.fill(whole, colours::cell);
        canvas.write(whole.x + gap(), whole.y + gap(), label, unit_, colours::text);
    }

private:
    /// The narrowest area that still shows something.
    static constexpr int least_area_pixels = 16;

    /// The largest of 1, 2, 5, 10, 20, ... that is at most `limit`; `decimals` are those that it takes.
    static double round_length(double limit, int& decimals) noexcept {
        double step = 1;
        decimals = 0;
        for (; step > limit && decimals < 9; ++decimals) {
            step /= 10;
        }
        while (step * 10 <= limit && step < 1e9) {
            step *= 10;
        }
        return step * 5 <= limit ? step * 5 : step * 2 <= limit ? step * 2 : step;
    }

    Rectangle cell(std::size_t i) const noexcept {
        const int column = static_cast<int>(i % static_cast<std::size_t>(columns_));
        const int row = static_cast<int>(i / static_cast<std::size_t>(columns_));
        return {gap() + column * (cell_width_ + gap()), heading_height() + row * (cell_height_ + gap()), cell_width_,
                cell_height_};
    }

    int gap() const noexcept { return 4 * unit_; }
    int heading_height() const noexcept { return text_height(unit_) + 2 * gap(); }
    int label_height() const noexcept { return text_height(unit_) + gap(); }
    double scale_with(const BoxMm& box, int columns, int rows, const PictureOptions& options) const noexcept {
        const double width = (static_cast<double>(options.width) - gap() * (columns + 1.0)) / columns - 2 * gap();
        const double height =
            (static_cast<double>(options.height) - heading_height() - gap() * static_cast<double>(rows)) / rows -
            label_height() - 2 * gap();
        return std::min(width / box.width(), height / box.height());
    }

    /// Returns where it begins.
    int draw_scale(Canvas& canvas) const {
        int decimals = 0;
        const double length_mm = round_length(std::min(0.5 * cell_width_, 0.25 * width_) / pixels_per_mm_, decimals);
        const std::string text = decimal_text(length_mm, decimals) + " mm";
        const int length = std::max(1, static_cast<int>(std::lround(length_mm * pixels_per_mm_)));
        const int right = width_ - gap() - text_width(text, unit_);
        const int left = right - 2 * unit_ - length;
        const int middle = gap() + text_height(unit_) / 2;
        canvas.write(right, gap(), text, unit_, colours::text);
        canvas.fill({left, middle - unit_ / 2, length, unit_}, colours::text);
        for (const int end : {left, left + length - unit_}) {
            canvas.fill({end, middle - 2 * unit_, unit_, 4 * unit_}, colours::text);
        }
        return left;
    }

    int unit_ = 1;
    int columns_ = 1;
    int cell_width_ = 0;
    int cell_height_ = 0;
    int width_ = 0;
    int height_ = 0;
    double pixels_per_mm_ = 0;
};

}  // namespace lamella
