// Layers of every part, drawn into rectangles of a canvas.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/medical/picture.hpp"
#include "medical/picture/canvas.hpp"

namespace lamella {

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

/// A part's layer; none where the part has none at that height.
struct DrawnLayer {
    const SliceResult* result = nullptr;
    const Layer* layer = nullptr;
    Colour colour;
};

/// The parts' layers at one height, and where on a canvas they are drawn.
struct Drawing {
    double height_mm = 0;
    std::vector<DrawnLayer> layers{};
    Rectangle area{};
};

inline constexpr Colour open_colour{0xd8, 0x1b, 0x1b};

/// How mm become pixels: the box lies in the middle of each drawing's area.
struct DrawingScale {
    BoxMm box;
    double pixels_per_mm = 1;
    double line_width = 1;  ///< of open polylines, pixels
    bool x_leftward = false;
    bool y_downward = false;
};

/// Draws on all threads. `background`: of the areas. Throws std::bad_alloc, Refused.
void draw_layers(Canvas& canvas, const std::vector<Drawing>& drawings, const DrawingScale& scale, Colour background,
                 const Parallel& parallel);

}  // namespace lamella
