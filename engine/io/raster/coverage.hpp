// How much of each voxel's area contours enclose: exact areas, summed row by row. And contours as they can be added up:
// where one winds around another, or repeats it, they are united first.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "lamella/layers.hpp"
#include "lamella/result.hpp"

namespace lamella {

/// What of a voxel counts: the share of its area, or whether its centre is inside; on the left or lower edge it is.
enum class Coverage : std::uint8_t { area, centre };

/// Signed-area accumulation, as in R. Levien's font-rs and in FreeType's smooth rasteriser: an edge changes the coverage of
/// the voxels that it passes, and of all to their right by its height.
///
/// Sums are in double precision, in the order of add(): the same contours in the same order give the same bits.
class CoverageSheet {
public:
    /// Zero everywhere; about rows [begin, end) of `width` voxels. All rows since the last restart were taken, or are zero.
    /// Throws std::bad_alloc.
    void restart(std::size_t width, std::size_t begin, std::size_t end, Coverage of = Coverage::area) {
        width_ = width;
        begin_ = begin;
        rows_ = end - begin;
        of_ = of;
        // One column more takes what falls to the right of the last. A row that was taken is zero already.
        words_ = width_ / word_bits + 1;
        steps_.resize(rows_ * (width_ + 1));
        touched_.resize(rows_ * words_);
    }

    /// A closed contour; counter-clockwise it adds, clockwise it takes away. `place` gives where a point lies, in voxels
    /// from the lower left corner of the first; `sign` is -1 where that turns the contour round.
    template <class Points, class Place>
    void add(const Points& contour, const Place& place, double sign = 1) {
        if (std::empty(contour)) {
            return;
        }
        const auto within = [&](const auto& point) {
            PointMm at = place(point);
            at.y -= static_cast<double>(begin_);
            return at;
        };
        PointMm from = within(contour[std::size(contour) - 1]);
        for (const auto& point : contour) {
            const PointMm to = within(point);
            if (from.y < to.y) {
                add_edge(from, to, -sign);
            } else if (to.y < from.y) {
                add_edge(to, from, sign);
            }
            from = to;
        }
    }

    /// Calls run(length, share) for the voxels of the i-th row from left to right, stretch by stretch of one share each, 0
    /// to 1, and sets the row to zero again. O(edges in the row + width / 64).
    template <class Run>
    void take_runs(std::size_t i, const Run& run) {
        double* const steps = steps_.data() + i * (width_ + 1);
        double sum = 0;
        std::size_t from = 0;
        const auto run_to = [&](std::size_t column) {
            if (column > from) {
                run(column - from, std::clamp(sum, 0.0, 1.0));
                from = column;
            }
        };
        for (std::size_t word = 0; word < words_; ++word) {
            for (std::uint64_t bits = std::exchange(touched_[i * words_ + word], 0); bits != 0; bits &= bits - 1) {
                const std::size_t column = word * word_bits + static_cast<std::size_t>(std::countr_zero(bits));
                run_to(column);
                sum += std::exchange(steps[column], 0.0);
            }
        }
        run_to(width_);  // contours that leave the image on the right cover all that is left of the row
    }

    /// Adds the shares of the i-th row to `to`, and sets the row to zero again.
    void take_row(std::size_t i, std::span<double> to) {
        double* at = to.data();
        take_runs(i, [&at](std::size_t length, double share) {
            for (double* const end = at + length; at != end; ++at) {
                *at += share;
            }
        });
    }

private:
    static constexpr std::size_t word_bits = 64;

    void add_edge(PointMm low, PointMm high, double sign) noexcept {
        of_ == Coverage::area ? add_areas(low, high, sign) : add_centres(low, high, sign);
    }

    /// In rows whose centres the edge passes, its lower end included: all voxels with their centre on it or to its right.
    void add_centres(PointMm low, PointMm high, double sign) noexcept {
        const double slope = (high.x - low.x) / (high.y - low.y);
        const auto row_of = [this](double y) {
            return static_cast<std::size_t>(std::clamp(std::ceil(y - 0.5), 0.0, static_cast<double>(rows_)));
        };
        const std::size_t end = row_of(high.y);
        for (std::size_t row = row_of(low.y); row < end; ++row) {
            const double column = std::ceil(low.x + (static_cast<double>(row) + 0.5 - low.y) * slope - 0.5);
            put(row, static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(width_))), sign);
        }
    }

    void add_areas(PointMm low, PointMm high, double sign) noexcept {
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

    /// A piece of an edge within a row: what lies to the left of the image counts as its left side, what lies to the right
    /// of it for nothing.
    void add_within_row(std::size_t row, double from_x, double to_x, double height) noexcept {
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
    void add_inside(std::size_t row, double from_x, double to_x, double height) noexcept {
        const auto first = std::min(static_cast<std::size_t>(from_x), width_ - 1);
        const auto last = std::min(static_cast<std::size_t>(to_x), width_ - 1);
        const double per_voxel = first < last ? height / (to_x - from_x) : 0;
        double before = 0;  // of the voxel to the left
        double risen = 0;   // height left of the voxel
        for (std::size_t column = first; column <= last; ++column) {
            const auto side = static_cast<double>(column);
            const double begin = std::max(from_x, side) - side;
            const double end = column < last ? 1 : to_x - side;
            const double rise = column < last ? per_voxel * (end - begin) : height - risen;
            const double area = risen + rise * (1 - 0.5 * (begin + end));
            put(row, column, area - before);
            before = area;
            risen += rise;
        }
        put(row, last + 1, height - before);
    }

    void put(std::size_t row, std::size_t column, double area) noexcept {
        steps_[row * (width_ + 1) + column] += area;
        touched_[row * words_ + column / word_bits] |= std::uint64_t{1} << column % word_bits;
    }

    std::size_t width_ = 0;
    std::size_t begin_ = 0;
    std::size_t rows_ = 0;
    std::vector<double> steps_;  ///< what each voxel has more than its left neighbour
    std::size_t words_ = 0;
    std::vector<std::uint64_t> touched_;  ///< a bit a column, so many words a row
    Coverage of_ = Coverage::area;
};

/// Unites one layer after another. Keep one a thread.
class SolidContours {
public:
    /// Closed contours of winding numbers 0 and 1 only, solid on the left: those of the layer where a fill rule has made a
    /// region of all of them, else their union by FillRule::non_zero. They stay until the next call. Throws Refused where
    /// memory fails.
    std::span<const std::span<const Point>> of(const SliceInfo& info, const LayerView& layer) {
        if (layer_ == layer.contours.data() && index_ == layer.index) {
            return contours_;
        }
        layer_ = layer.contours.data();
        index_ = layer.index;
        contours_.clear();
        for (const Contour& contour : layer.contours) {
            if (contour.encloses_area()) {
                contours_.push_back(layer.points_of(contour));
            }
        }
        const SliceOptions& options = info.options;
        const bool apart = info.part_count > 1 && !options.unite_parts;
        if (!apart && options.region.rule_of(info.first_layer + layer.index) != FillRule::contours) {
            return contours_;
        }
        united_ = require(region_of(contours_, {.fill_rule = FillRule::non_zero}));
        contours_.clear();
        for (const Contour& contour : united_.contours) {
            contours_.push_back(united_.points_of(contour));
        }
        return contours_;
    }

private:
    const Contour* layer_ = nullptr;  ///< that was asked for last
    std::uint64_t index_ = 0;
    std::vector<std::span<const Point>> contours_;
    SliceResult united_;
};

/// How long a closed contour is, grid units.
inline double perimeter_of(std::span<const Point> points) noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& p = points[i];
        const Point& q = points[i + 1 < points.size() ? i + 1 : 0];
        sum += std::sqrt(std::pow(static_cast<double>(std::int64_t{q.x} - p.x), 2) +
                         std::pow(static_cast<double>(std::int64_t{q.y} - p.y), 2));
    }
    return sum;
}

}  // namespace lamella
