// Where on a picture the cells, the names and the scale lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lamella/medical/picture.hpp"
#include "medical/picture/canvas.hpp"
#include "medical/picture/draw_layers.hpp"

namespace lamella {

namespace colours {
inline constexpr Colour page{0xff, 0xff, 0xff};
inline constexpr Colour cell{0xf1, 0xf3, 0xf5};
inline constexpr Colour text{0x2b, 0x30, 0x36};
}  // namespace colours

/// Colours repeat after twelve parts.
Colour colour_of_part(std::size_t part) noexcept;

/// Cells of one size in rows, below a line with names and scale.
class Page {
public:
    /// Chooses the number of columns that gives the largest scale. `label_width`: of the widest label, in dots of the font.
    /// Throws Refused where the cells would be too small.
    Page(const BoxMm& box, std::size_t cells, int label_width, const PictureOptions& options);

    int unit() const noexcept { return unit_; }  ///< pixels of a dot of the font
    int width() const noexcept { return width_; }
    int height() const noexcept { return height_; }
    double pixels_per_mm() const noexcept { return pixels_per_mm_; }
    /// The part of a cell that the layer is drawn into.
    Rectangle area(std::size_t i) const noexcept;

    /// One line: a coloured square and the name of each part as far as they go, how many layers have open polylines
    /// if any, and a bar of a round length.
    void draw_heading(Canvas& canvas, const std::vector<std::string>& names, std::uint64_t open_layers) const;
    /// A cell without its layer.
    void draw_cell(Canvas& canvas, std::size_t i, const std::string& label) const;

private:
    Rectangle cell(std::size_t i) const noexcept;
    int gap() const noexcept { return 4 * unit_; }
    int heading_height() const noexcept { return text_height(unit_) + 2 * gap(); }
    int label_height() const noexcept { return text_height(unit_) + gap(); }
    double scale_with(const BoxMm& box, int columns, int rows, const PictureOptions& options) const noexcept;
    int draw_scale(Canvas& canvas) const;

    int unit_ = 1;
    int columns_ = 1;
    int cell_width_ = 0;
    int cell_height_ = 0;
    int width_ = 0;
    int height_ = 0;
    double pixels_per_mm_ = 0;
};

/// With so many decimals, without a sign where it rounds to zero.
std::string decimal_text(double value, int decimals);

}  // namespace lamella
