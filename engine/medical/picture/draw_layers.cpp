#include "medical/picture/draw_layers.hpp"

#include <array>
#include <cmath>
#include <span>

#include "medical/raster/coverage.hpp"
#include "medical/raster/solid_contours.hpp"

namespace lamella {

namespace {

/// Parts of a pixel that points are rounded to: a side of largest_picture_side pixels stays within 2^27.
constexpr double fractions = 4096;
constexpr double per_fraction[2] = {1 / fractions, 1 / fractions};

/// Overlaps show, and so does which part is the later one.
constexpr double opacity_over_others = 0.75;

/// The sheet counts from the centre of its first pixel.
Point fine(PointMm pixels) noexcept {
    return {static_cast<std::int32_t>(std::lround((pixels.x - 0.5) * fractions)),
            static_cast<std::int32_t>(std::lround((pixels.y - 0.5) * fractions))};
}

/// Rows of one drawing, so few that a sheet of them takes some MB.
struct Strip {
    const Drawing* drawing = nullptr;
    int begin = 0;
    int end = 0;
};

std::vector<Strip> strips_of(const std::vector<Drawing>& drawings) {
    constexpr int most_pixels = 1 << 18;
    std::vector<Strip> strips;
    for (const Drawing& drawing : drawings) {
        const int rows = std::max(1, most_pixels / drawing.area.width);
        for (int begin = 0; begin < drawing.area.height; begin += rows) {
            strips.push_back({&drawing, begin, std::min(drawing.area.height, begin + rows)});
        }
    }
    return strips;
}

/// Draws strips. One a thread.
class LayerBrush {
public:
    LayerBrush(Canvas& canvas, const DrawingScale& scale, Colour background)
        : canvas_(canvas), scale_(scale), background_(background) {}

    void draw(const Strip& strip) {
        strip_ = strip;
        const Rectangle& area = strip.drawing->area;
        x_scale_ = scale_.x_leftward ? -scale_.pixels_per_mm : scale_.pixels_per_mm;
        y_scale_ = scale_.y_downward ? scale_.pixels_per_mm : -scale_.pixels_per_mm;
        shift_ = {0.5 * area.width - x_scale_ * (scale_.box.min.x + 0.5 * scale_.box.width()),
                  0.5 * area.height - y_scale_ * (scale_.box.min.y + 0.5 * scale_.box.height())};
        sheet_.restart(static_cast<std::size_t>(area.width), static_cast<std::size_t>(strip.begin),
                       static_cast<std::size_t>(strip.end));
        shares_.resize(static_cast<std::size_t>(area.width));
        for (const DrawnLayer& drawn : strip.drawing->layers) {
            if (drawn.layer != nullptr) {
                add_filled(drawn);
                mix_rows(drawn.colour, opacity_over_others);
            }
        }
        bool open = false;
        for (const DrawnLayer& drawn : strip.drawing->layers) {
            open = (drawn.layer != nullptr && add_open(drawn)) || open;
        }
        if (open) {
            mix_rows(open_colour, 1);
        }
    }

private:
    PointMm pixels(const SliceResult& result, const Point& point) const noexcept {
        const PointMm mm = result.to_mm(point);
        return {x_scale_ * mm.x + shift_.x, y_scale_ * mm.y + shift_.y};
    }

    void add_filled(const DrawnLayer& drawn) {
        for (const std::span<const Point> points : solid_.of(*drawn.result, *drawn.layer)) {
            contour_.clear();
            for (const Point& point : points) {
                contour_.push_back(fine(pixels(*drawn.result, point)));
            }
            if (x_scale_ * y_scale_ < 0) {  // what was counter-clockwise is clockwise on the picture
                std::reverse(contour_.begin(), contour_.end());
            }
            sheet_.add(contour_, per_fraction);
        }
    }

    /// Returns whether there was any.
    bool add_open(const DrawnLayer& drawn) {
        bool any = false;
        for (const Contour& contour : drawn.result->contours_of(*drawn.layer)) {
            const std::span<const Point> points = drawn.result->points_of(contour);
            for (std::size_t i = 1; contour.role == Role::open && i < points.size(); ++i) {
                any = true;
                add_line(pixels(*drawn.result, points[i - 1]), pixels(*drawn.result, points[i]));
            }
        }
        return any;
    }

    /// A counter-clockwise rectangle about the line, half a width longer at both ends.
    void add_line(PointMm from, PointMm to) {
        const double half = scale_.line_width / 2;
        const double length = std::sqrt((to.x - from.x) * (to.x - from.x) + (to.y - from.y) * (to.y - from.y));
        const double x = length > 0 ? half * (to.x - from.x) / length : half;
        const double y = length > 0 ? half * (to.y - from.y) / length : 0;
        const std::array<Point, 4> corners = {fine({from.x - x + y, from.y - y - x}), fine({to.x + x + y, to.y + y - x}),
                                              fine({to.x + x - y, to.y + y + x}), fine({from.x - x - y, from.y - y + x})};
        sheet_.add(corners, per_fraction);
    }

    /// `over_others`: the opacity where something else than the background is.
    void mix_rows(Colour colour, double over_others) {
        const Rectangle& area = strip_.drawing->area;
        for (int row = strip_.begin; row < strip_.end; ++row) {
            std::fill(shares_.begin(), shares_.end(), 0.0);
            sheet_.take_row(static_cast<std::size_t>(row - strip_.begin), shares_);
            for (int column = 0; column < area.width; ++column) {
                if (const double share = shares_[static_cast<std::size_t>(column)]; share > 0) {
                    const int x = area.x + column;
                    const int y = area.y + row;
                    canvas_.mix(x, y, colour, canvas_.has(x, y, background_) ? share : over_others * share);
                }
            }
        }
    }

    Canvas& canvas_;
    const DrawingScale& scale_;
    Colour background_;
    Strip strip_;
    double x_scale_ = 1;
    double y_scale_ = 1;
    PointMm shift_{};
    CoverageSheet sheet_;
    SolidContours solid_;
    std::vector<Point> contour_;  ///< in fractions of a pixel
    std::vector<double> shares_;  ///< of a row
};

}  // namespace

void draw_layers(Canvas& canvas, const std::vector<Drawing>& drawings, const DrawingScale& scale, Colour background,
                 const Parallel& parallel) {
    const std::vector<Strip> strips = strips_of(drawings);
    std::vector<LayerBrush> brushes;
    for (std::size_t worker = 0; worker < parallel.workers_for(strips.size()); ++worker) {
        brushes.emplace_back(canvas, scale, background);
    }
    parallel.run(strips.size(),
                 [&](std::size_t i, int worker) { brushes[static_cast<std::size_t>(worker)].draw(strips[i]); });
}

}  // namespace lamella
