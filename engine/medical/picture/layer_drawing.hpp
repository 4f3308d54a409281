// A layer of every part, drawn into a rectangle of a canvas.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "lamella/medical/picture.hpp"
#include "medical/picture/canvas.hpp"
#include "medical/raster/coverage.hpp"
#include "medical/raster/solid_contours.hpp"

namespace lamella {

/// In mm, in the frame of the slicing.
struct BoxMm {
    PointMm min{};
    PointMm max{};

    double width() const noexcept { return max.x - min.x; }
    double height() const noexcept { return max.y - min.y; }
    void widen(PointMm at) noexcept;
};

/// From mm to the pixels of a rectangle, from its upper left corner.
class View {
public:
    /// Centres the box in the rectangle.
    View(const BoxMm& box, double pixels_per_mm, Rectangle rectangle, const PictureOptions& options) noexcept;

    const Rectangle& rectangle() const noexcept { return rectangle_; }
    /// Whether a counter-clockwise contour is clockwise on the picture.
    bool mirrored() const noexcept { return x_.scale * y_.scale < 0; }
    PointMm at(PointMm mm) const noexcept { return {x_.scale * mm.x + x_.shift, y_.scale * mm.y + y_.shift}; }

private:
    struct Axis {
        double scale = 1;
        double shift = 0;
    };
    Rectangle rectangle_;
    Axis x_;
    Axis y_;
};

/// A part's layer; none where the part has none at that height.
struct DrawnLayer {
    const SliceResult* result = nullptr;
    const Layer* layer = nullptr;
    Colour colour;
};

inline constexpr Colour open_colour{0xd8, 0x1b, 0x1b};

/// Draws rows of a view. Keep one a thread.
class LayerBrush {
public:
    /// Rows [begin, end) of the view's rectangle. `background`: of the cell. `line_width`: of open polylines, in
    /// pixels.
    /// Throws std::bad_alloc.
    void draw(Canvas& canvas, const View& view, std::span<const DrawnLayer> layers, Colour background, double line_width,
              int begin, int end);

private:
    struct Paint {
        Colour colour;
        Colour background;
        double over_others;  ///< opacity where something else than the background is
    };
    void begin_rows(const View& view, int begin, int end);
    void add_filled(const View& view, const DrawnLayer& drawn);
    bool add_open(const View& view, const DrawnLayer& drawn, double line_width);
    void add_line(PointMm from, PointMm to, double line_width);
    void mix_rows(Canvas& canvas, const View& view, const Paint& paint, int begin, int end);

    CoverageSheet sheet_;
    SolidContours solid_;
    std::vector<Point> contour_;  ///< in fractions of a pixel
    std::vector<double> shares_;  ///< of a row
};

}  // namespace lamella
