// Where the centres of voxels lie on the grid of a result, and where contours cross their rows: exact, by integers.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella {

/// The centres of voxels 0, 1, ... along one axis in grid units, each rounded: they ascend, and where voxels are smaller
/// than a unit several share a place. What lies beyond the grid stands just beyond it, where no contour reaches.
class Centres {
public:
    /// Preconditions: the lengths are finite and above 0. Throws std::bad_alloc.
    Centres(std::size_t count, double spacing_mm, double grid_mm)
        : places_(count + 2), voxels_per_unit_(grid_mm / spacing_mm) {
        constexpr std::int64_t beyond = std::int64_t{grid_limit} + 1;
        for (std::size_t voxel = 0; voxel < count; ++voxel) {
            const double place = std::round(static_cast<double>(voxel) * spacing_mm / grid_mm);
            places_[voxel + 1] = place < static_cast<double>(beyond) ? static_cast<std::int64_t>(place) : beyond;
        }
        places_.front() = std::numeric_limits<std::int64_t>::min();
        places_.back() = std::numeric_limits<std::int64_t>::max();
    }

    std::size_t size() const noexcept { return places_.size() - 2; }
    std::int64_t operator[](std::size_t voxel) const noexcept { return places_[voxel + 1]; }

    /// The first voxel whose centre lies at `place` or after it; size() where none does. O(1), or O(log n) where voxels are
    /// about as small as a unit.
    std::size_t first_from(std::int64_t place) const noexcept {
        const double guess = static_cast<double>(place) * voxels_per_unit_ + 1;  // the entry in places_
        const auto last = static_cast<double>(places_.size() - 1);
        auto entry = static_cast<std::size_t>(guess < 1 ? 1 : guess > last ? last : guess);
        entry += static_cast<std::size_t>(places_[entry] < place);
        return places_[entry - 1] < place && place <= places_[entry] ? entry - 1 : search(place);
    }

    /// first_from(place) is `voxel`.
    bool begins(std::size_t voxel, std::int64_t place) const noexcept {
        return places_[voxel] < place && place <= places_[voxel + 1];
    }

private:
    std::size_t search(std::int64_t place) const noexcept {
        return static_cast<std::size_t>(std::lower_bound(places_.begin() + 1, places_.end() - 1, place) - places_.begin()) -
               1;
    }

    std::vector<std::int64_t> places_;  ///< between two that no coordinate reaches
    double voxels_per_unit_;
};

/// A contour of `part` passes a row: from voxel `column` on, centres lie to its right. Ordered by part, then by column.
class Crossing {
public:
    Crossing() = default;
    Crossing(std::uint32_t part, std::size_t column, bool upward) noexcept
        : key_(std::uint64_t{part} << 32 | static_cast<std::uint64_t>(column) << 1 | static_cast<std::uint64_t>(upward)) {}
    std::uint32_t part() const noexcept { return static_cast<std::uint32_t>(key_ >> 32); }
    std::size_t column() const noexcept { return static_cast<std::uint32_t>(key_) >> 1; }
    int winding() const noexcept { return (key_ & 1) != 0 ? 1 : -1; }
    friend auto operator<=>(const Crossing&, const Crossing&) = default;

private:
    std::uint64_t key_ = 0;
};

/// The crossings of a range of rows. An edge crosses the rows whose centres lie at its lower end or above, and below its
/// upper end; it lies to the left of the centres at its place or to the right: so left and bottom edges are inside.
class RowCrossings {
public:
    /// Forgets all; from here on about rows [begin, end).
    void restart(std::size_t begin, std::size_t end) {
        begin_ = begin;
        end_ = end;
        found_.clear();
    }

    /// A closed contour of any orientation. Preconditions: its points are within grid_limit.
    void add(std::span<const Point> contour, const Centres& columns, const Centres& rows, std::uint32_t part) {
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

    /// After the last add(): brings the crossings in the order of rows.
    void sort() {
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

    /// Those of the i-th row of the range, sorted.
    std::span<const Crossing> of_row(std::size_t i) const noexcept {
        return std::span(sorted_).subspan(first_[i], first_[i + 1] - first_[i]);
    }

private:
    /// The quotient rounded up. |numerator| <= 2^62, 0 < denominator <= 2^31, and the quotient fits 32 bits: the quotient of
    /// doubles, which takes a third of the time of the integers', is at most one off.
    static std::int64_t ceiling(std::int64_t numerator, std::int64_t denominator) noexcept {
        auto quotient = static_cast<std::int64_t>(static_cast<double>(numerator) / static_cast<double>(denominator));
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient -= static_cast<std::int64_t>((quotient - 1) * denominator >= numerator);
        return quotient;
    }

    struct Found {
        Crossing crossing;
        std::uint32_t row = 0;
    };
    void add_edge(Point low, Point high, std::size_t first_row, std::size_t end_row, bool upward, const Centres& columns,
                  const Centres& rows, std::uint32_t part) {
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

    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    std::vector<Found> found_;
    std::vector<std::size_t> first_;  ///< of each row, in sorted_
    std::vector<Crossing> sorted_;
};

/// Calls span(begin, end) for the voxels of a row whose winding number is not 0. `crossings`: of one part, sorted.
template <class Span>
void for_each_span(std::span<const Crossing> crossings, std::size_t width, Span&& span) {
    int winding = 0;
    std::size_t begin = 0;
    for (const Crossing& crossing : crossings) {
        if (winding == 0) {
            begin = crossing.column();
        }
        winding += crossing.winding();
        if (winding == 0 && crossing.column() > begin) {
            span(begin, crossing.column());
        }
    }
    if (winding != 0) {
        span(begin, width);
    }
}

}  // namespace lamella
