#include "medical/picture/layer_drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace lamella {

namespace {

/// Parts of a pixel that points are rounded to: a side of largest_picture_side pixels stays within 2^27.
constexpr double fractions = 4096;

/// The sheet counts from the centre of its first pixel.
Point fine(PointMm pixels) noexcept {
    return {static_cast<std::int32_t>(std::lround((pixels.x - 0.5) * fractions)),
            static_cast<std::int32_t>(std::lround((pixels.y - 0.5) * fractions))};
}

/// Overlaps show, and so does which part is the later one.
constexpr double opacity_over_others = 0.75;

constexpr double per_fraction[2] = {1 / fractions, 1 / fractions};

}  // namespace

void BoxMm::widen(PointMm at) noexcept {
    min = {std::min(min.x, at.x), std::min(min.y, at.y)};
    max = {std::max(max.x, at.x), std::max(max.y, at.y)};
}

View::View(const BoxMm& box, double pixels_per_mm, Rectangle rectangle, const PictureOptions& options) noexcept
    : rectangle_(rectangle) {
    x_.scale = options.x_leftward ? -pixels_per_mm : pixels_per_mm;
    y_.scale = options.y_downward ? pixels_per_mm : -pixels_per_mm;
    x_.shift = 0.5 * rectangle.width - x_.scale * (box.min.x + 0.5 * box.width());
    y_.shift = 0.5 * rectangle.height - y_.scale * (box.min.y + 0.5 * box.height());
}

void LayerBrush::begin_rows(const View& view, int begin, int end) {
    const auto width = static_cast<std::size_t>(view.rectangle().width);
    sheet_.restart(width, static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
    shares_.assign(width, 0);
}

void LayerBrush::add_filled(const View& view, const DrawnLayer& drawn) {
    for (const std::span<const Point> points : solid_.of(*drawn.result, *drawn.layer)) {
        contour_.clear();
        for (const Point& point : points) {
            contour_.push_back(fine(view.at(drawn.result->to_mm(point))));
        }
        if (view.mirrored()) {
            std::reverse(contour_.begin(), contour_.end());
        }
        sheet_.add(contour_, per_fraction);
    }
}

bool LayerBrush::add_open(const View& view, const DrawnLayer& drawn, double line_width) {
    bool any = false;
    for (const Contour& contour : drawn.result->contours_of(*drawn.layer)) {
        if (contour.role != Role::open) {
            continue;
        }
        any = true;
        const std::span<const Point> points = drawn.result->points_of(contour);
        for (std::size_t i = 1; i < points.size(); ++i) {
            add_line(view.at(drawn.result->to_mm(points[i - 1])), view.at(drawn.result->to_mm(points[i])), line_width);
        }
    }
    return any;
}

/// A counter-clockwise rectangle about the line, half a width longer at both ends.
void LayerBrush::add_line(PointMm from, PointMm to, double line_width) {
    const double half = line_width / 2;
    const double length = std::sqrt((to.x - from.x) * (to.x - from.x) + (to.y - from.y) * (to.y - from.y));
    const double x = length > 0 ? half * (to.x - from.x) / length : half;
    const double y = length > 0 ? half * (to.y - from.y) / length : 0;
    const std::array<Point, 4> corners = {fine({from.x - x + y, from.y - y - x}), fine({to.x + x + y, to.y + y - x}),
                                          fine({to.x + x - y, to.y + y + x}), fine({from.x - x - y, from.y - y + x})};
    sheet_.add(corners, per_fraction);
}

void LayerBrush::mix_rows(Canvas& canvas, const View& view, const Paint& paint, int begin, int end) {
    const Rectangle& area = view.rectangle();
    for (int row = begin; row < end; ++row) {
        std::fill(shares_.begin(), shares_.end(), 0.0);
        sheet_.take_row(static_cast<std::size_t>(row - begin), shares_);
        for (int column = 0; column < area.width; ++column) {
            if (const double share = shares_[static_cast<std::size_t>(column)]; share > 0) {
                const int x = area.x + column;
                const int y = area.y + row;
                canvas.mix(x, y, paint.colour, canvas.has(x, y, paint.background) ? share : paint.over_others * share);
            }
        }
    }
}

void LayerBrush::draw(Canvas& canvas, const View& view, std::span<const DrawnLayer> layers, Colour background,
                      double line_width, int begin, int end) {
    begin_rows(view, begin, end);
    for (const DrawnLayer& drawn : layers) {
        if (drawn.layer != nullptr) {
            add_filled(view, drawn);
            mix_rows(canvas, view, {drawn.colour, background, opacity_over_others}, begin, end);
        }
    }
    bool open = false;
    for (const DrawnLayer& drawn : layers) {
        open = (drawn.layer != nullptr && add_open(view, drawn, line_width)) || open;
    }
    if (open) {
        mix_rows(canvas, view, {open_colour, background, 1}, begin, end);
    }
}

}  // namespace lamella
