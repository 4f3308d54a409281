// Source: signed-area accumulation, as in R. Levien's font-rs and in FreeType's smooth rasteriser: an edge changes the
// coverage of the voxels that it passes, and of all to their right by its height.
#include "medical/raster/coverage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lamella {

namespace {
constexpr std::size_t untouched = std::numeric_limits<std::size_t>::max();
}

void CoverageSheet::restart(std::size_t width, std::size_t begin, std::size_t end) {
    width_ = width;
    begin_ = begin;
    rows_ = end - begin;
    // One column more takes what falls to the right of the last. A row that was taken is zero already.
    steps_.assign(rows_ * (width_ + 1), 0.0);
    touched_.assign(rows_, {untouched, 0});
}

void CoverageSheet::add(std::span<const Point> contour, const double (&voxels_per_unit)[2]) {
    if (contour.empty()) {
        return;
    }
    const auto place = [&](const Point& point) {
        return At{point.x * voxels_per_unit[0] + 0.5, point.y * voxels_per_unit[1] + 0.5 - static_cast<double>(begin_)};
    };
    At from = place(contour.back());
    for (const Point& point : contour) {
        const At to = place(point);
        if (from.y < to.y) {
            add_edge(from, to, -1);
        } else if (to.y < from.y) {
            add_edge(to, from, 1);
        }
        from = to;
    }
}

void CoverageSheet::add_edge(At low, At high, double sign) noexcept {
    const auto rows = static_cast<double>(rows_);
    if (high.y <= 0 || low.y >= rows) {
        return;
    }
    const double slope = (high.x - low.x) / (high.y - low.y);
    const auto first = static_cast<std::size_t>(std::max(low.y, 0.0));
    const auto end = static_cast<std::size_t>(std::ceil(std::min(high.y, rows)));
    const double least_x = std::min(low.x, high.x);
    const double largest_x = std::max(low.x, high.x);
    for (std::size_t row = first; row < end; ++row) {
        const auto bottom = static_cast<double>(row);
        const double from_y = std::max(low.y, bottom);
        const double to_y = std::min(high.y, bottom + 1);
        const double from_x = from_y == low.y ? low.x : low.x + (from_y - low.y) * slope;
        const double to_x = to_y == high.y ? high.x : low.x + (to_y - low.y) * slope;
        add_within_row(row, std::clamp(from_x, least_x, largest_x), std::clamp(to_x, least_x, largest_x),
                       sign * (to_y - from_y));
    }
}

/// A piece of an edge within a row: what lies to the left of the image counts as its left side, what lies to the right of
/// it for nothing.
void CoverageSheet::add_within_row(std::size_t row, double from_x, double to_x, double height) noexcept {
    if (from_x > to_x) {
        std::swap(from_x, to_x);
    }
    const auto right = static_cast<double>(width_);
    if (to_x <= 0) {
        put(row, 0, height);
        return;
    }
    if (from_x >= right) {
        return;
    }
    const double length = to_x - from_x;
    if (from_x < 0) {
        const double outside = height * (-from_x / length);
        put(row, 0, outside);
        height -= outside;
        from_x = 0;
    }
    if (to_x > right) {
        height *= (right - from_x) / (to_x - from_x);
        to_x = right;
    }
    add_inside(row, from_x, to_x, height);
}

/// Voxel by voxel, from left to right: what the piece adds to the area of each voxel up to this one.
void CoverageSheet::add_inside(std::size_t row, double from_x, double to_x, double height) noexcept {
    const auto first = std::min(static_cast<std::size_t>(from_x), width_ - 1);
    const auto last = std::min(static_cast<std::size_t>(to_x), width_ - 1);
    double before = 0;  // of the voxel to the left
    if (first < last) {
        const double per_voxel = height / (to_x - from_x);
        double risen = 0;  // height left of the voxel
        for (std::size_t column = first; column < last; ++column) {
            const double side = static_cast<double>(column) + 1;
            const double width = side - std::max(from_x, static_cast<double>(column));
            const double rise = per_voxel * width;
            const double area = risen + rise * (0.5 * width);
            put(row, column, area - before);
            before = area;
            risen += rise;
        }
        const double rest = height - risen;
        const auto side = static_cast<double>(last);
        const double area = risen + rest * (1 - 0.5 * (to_x - side));
        put(row, last, area - before);
        before = area;
    } else {
        before = height * (1 - (0.5 * (from_x + to_x) - static_cast<double>(first)));
        put(row, first, before);
    }
    put(row, last + 1, height - before);
}

void CoverageSheet::put(std::size_t row, std::size_t column, double area) noexcept {
    steps_[row * (width_ + 1) + column] += area;
    Touched& touched = touched_[row];
    touched.first = std::min(touched.first, column);
    touched.last = std::max(touched.last, column);
}

void CoverageSheet::take_row(std::size_t i, std::span<double> to) noexcept {
    const Touched touched = touched_[i];
    if (touched.first == untouched) {
        return;
    }
    double* const steps = steps_.data() + i * (width_ + 1);
    double sum = 0;
    for (std::size_t column = touched.first; column <= std::min(touched.last, width_ - 1); ++column) {
        sum += std::exchange(steps[column], 0.0);
        to[column] += std::clamp(sum, 0.0, 1.0);
    }
    // Contours that leave the image on the right cover all that is left of the row.
    for (std::size_t column = touched.last + 1; column < width_; ++column) {
        to[column] += std::clamp(sum, 0.0, 1.0);
    }
    steps[width_] = 0;
    touched_[i] = {untouched, 0};
}

}  // namespace lamella
