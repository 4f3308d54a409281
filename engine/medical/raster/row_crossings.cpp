#include "medical/raster/row_crossings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lamella {

namespace {

/// The quotient rounded up. |numerator| <= 2^62, 0 < denominator <= 2^31, and the quotient fits 32 bits: the quotient of
/// doubles, which takes a third of the time of the integers', is at most one off.
std::int64_t ceiling(std::int64_t numerator, std::int64_t denominator) noexcept {
    auto quotient = static_cast<std::int64_t>(static_cast<double>(numerator) / static_cast<double>(denominator));
    quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
    quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
    quotient -= static_cast<std::int64_t>((quotient - 1) * denominator >= numerator);
    return quotient;
}

}  // namespace

Centres::Centres(std::size_t count, double spacing_mm, double unit_mm)
    : places_(count + 2), voxels_per_unit_(unit_mm / spacing_mm) {
    constexpr std::int64_t beyond = std::int64_t{grid_limit} + 1;
    for (std::size_t voxel = 0; voxel < count; ++voxel) {
        const double place = std::round(static_cast<double>(voxel) * spacing_mm / unit_mm);
        places_[voxel + 1] = place < static_cast<double>(beyond) ? static_cast<std::int64_t>(place) : beyond;
    }
    places_.front() = std::numeric_limits<std::int64_t>::min();
    places_.back() = std::numeric_limits<std::int64_t>::max();
}

std::size_t Centres::search(std::int64_t place) const noexcept {
    return static_cast<std::size_t>(std::lower_bound(places_.begin() + 1, places_.end() - 1, place) - places_.begin()) - 1;
}

void RowCrossings::restart(std::size_t begin, std::size_t end) {
    begin_ = begin;
    end_ = end;
    found_.clear();
}

void RowCrossings::add(std::span<const Point> contour, const Centres& columns, const Centres& rows, std::uint32_t part) {
    if (contour.empty()) {
        return;
    }
    Point from = contour.back();
    std::size_t from_row = rows.first_from(from.y);
    for (const Point& to : contour) {
        if (!rows.begins(from_row, to.y)) {
            const std::size_t to_row = rows.first_from(to.y);
            if (from_row < to_row) {
                add_edge(from, to, from_row, to_row, true, columns, rows, part);
            } else {
                add_edge(to, from, to_row, from_row, false, columns, rows, part);
            }
            from_row = to_row;
        }
        from = to;
    }
}

void RowCrossings::add_edge(Point low, Point high, std::size_t first_row, std::size_t end_row, bool upward,
                            const Centres& columns, const Centres& rows, std::uint32_t part) {
    const std::int64_t run = std::int64_t{high.x} - low.x;
    const std::int64_t rise = std::int64_t{high.y} - low.y;
    const std::size_t end = std::min(end_row, end_);
    for (std::size_t row = std::max(first_row, begin_); row < end; ++row) {
        const std::size_t column = columns.first_from(low.x + ceiling((rows[row] - low.y) * run, rise));
        if (column < columns.size()) {
            found_.push_back({Crossing(part, column, upward), static_cast<std::uint32_t>(row - begin_)});
        }
    }
}

void RowCrossings::sort() {
    const std::size_t rows = end_ - begin_;
    first_.assign(rows + 2, 0);
    for (const Found& found : found_) {
        ++first_[found.row + 2];
    }
    for (std::size_t row = 2; row < rows + 2; ++row) {
        first_[row] += first_[row - 1];
    }
    sorted_.resize(found_.size());
    for (const Found& found : found_) {
        sorted_[first_[found.row + 1]++] = found.crossing;
    }
    for (std::size_t row = 0; row < rows; ++row) {
        const auto begin = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row]);
        const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row + 1]);
        if (end - begin == 2) {
            if (begin[1] < begin[0]) {
                std::swap(begin[0], begin[1]);
            }
        } else {
            std::sort(begin, end);
        }
    }
}

}  // namespace lamella
