// Where the centres of voxels lie on the grid of a result, and where contours cross their rows: exact, by integers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
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

/// Where contours cross the rows of an image. An edge crosses the rows whose centres lie at its lower end or above, and
/// below its upper end; it lies to the left of the centres at its place or to the right: so left and bottom edges are
/// inside.
class RowCrossings {
public:
    /// Forgets all.
    void restart(std::size_t rows) {
        found_.clear();
        first_.assign(rows + 2, 0);
    }

    /// A closed contour of any orientation. Preconditions: its points are within grid_limit.
    void add(std::span<const Point> contour, const Centres& columns, const Centres& rows) {
        if (contour.empty()) {
            return;
        }
        Point from = contour.back();
        std::size_t from_row = rows.first_from(from.y);
        for (const Point& to : contour) {
            if (!rows.begins(from_row, to.y)) {
                const std::size_t to_row = rows.first_from(to.y);
                if (from_row < to_row) {
                    add_edge(from, to, from_row, to_row, upward, columns, rows);
                } else {
                    add_edge(to, from, to_row, from_row, 0, columns, rows);
                }
                from_row = to_row;
            }
            from = to;
        }
    }

    /// After the last add(): calls span(row, begin, end) for the voxels of each row, `width` long, whose winding number is
    /// not 0.
    template <class Span>
    void for_each_span(std::size_t width, Span&& span) {
        sort_by_rows();
        for (std::size_t row = 0; row + 2 < first_.size(); ++row) {
            const auto row_begin = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row]);
            const auto row_end = sorted_.begin() + static_cast<std::ptrdiff_t>(first_[row + 1]);
            std::sort(row_begin, row_end);
            int winding = 0;
            std::size_t begin = 0;
            for (auto crossing = row_begin; crossing != row_end; ++crossing) {
                const std::size_t column = *crossing >> 1;
                begin = winding == 0 ? column : begin;
                winding += (*crossing & upward) != 0 ? 1 : -1;
                if (winding == 0 && column > begin) {
                    span(row, begin, column);
                }
            }
            if (winding != 0) {
                span(row, begin, width);
            }
        }
    }

private:
    static constexpr std::uint32_t upward = 1;

    /// From voxel `column` on, centres lie to the right of a contour. Ordered by column.
    struct Crossing {
        std::uint32_t row = 0;
        std::uint32_t column_and_way = 0;  ///< 2 column, and `upward` where the contour runs so
    };

    /// The quotient rounded up. |numerator| <= 2^62, 0 < denominator <= 2^31, and the quotient fits 32 bits: the quotient of
    /// doubles, which takes a third of the time of the integers', is at most one off.
    static std::int64_t ceiling(std::int64_t numerator, std::int64_t denominator) noexcept {
        auto quotient = static_cast<std::int64_t>(static_cast<double>(numerator) / static_cast<double>(denominator));
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient += static_cast<std::int64_t>(quotient * denominator < numerator);
        quotient -= static_cast<std::int64_t>((quotient - 1) * denominator >= numerator);
        return quotient;
    }

    void add_edge(Point low, Point high, std::size_t first_row, std::size_t end_row, std::uint32_t way,
                  const Centres& columns, const Centres& rows) {
        const std::int64_t run = std::int64_t{high.x} - low.x;
        const std::int64_t rise = std::int64_t{high.y} - low.y;
        for (std::size_t row = first_row; row < end_row; ++row) {
            const std::size_t column = columns.first_from(low.x + ceiling((rows[row] - low.y) * run, rise));
            if (column < columns.size()) {
                found_.push_back({static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column) << 1 | way});
                ++first_[row + 2];
            }
        }
    }

    void sort_by_rows() {
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        sorted_.resize(found_.size());
        for (const Crossing& crossing : found_) {
            sorted_[first_[crossing.row + 1]++] = crossing.column_and_way;
        }
    }

    std::vector<Crossing> found_;
    std::vector<std::size_t> first_;  ///< of each row, in sorted_; two places after it until they are sorted
    std::vector<std::uint32_t> sorted_;
};

}  // namespace lamella
