// How much of each voxel's area contours enclose: exact areas, summed row by row.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "lamella/grid.hpp"

namespace lamella {

/// A sheet of voxels in the order of rows: voxel (i, j) reaches half a voxel around (i, j). Sums are in double precision, in
/// the order of add(): the same contours in the same order give the same bits.
class CoverageSheet {
public:
    /// Zero everywhere; about rows [begin, end) of `width` voxels. Throws std::bad_alloc.
    void restart(std::size_t width, std::size_t begin, std::size_t end);

    /// A closed contour; counter-clockwise it adds, clockwise it takes away. `voxels_per_unit`: along x and y.
    void add(std::span<const Point> contour, const double (&voxels_per_unit)[2]);

    /// Adds the share of each voxel of the i-th row of the range, 0 to 1, to `to`, and sets the row to zero again.
    void take_row(std::size_t i, std::span<double> to) noexcept;

private:
    struct At {
        double x = 0;  ///< in voxels, from the left side of the first
        double y = 0;  ///< from the lower side of the range's first row
    };
    /// Columns of a row that were touched: [first, last].
    struct Touched {
        std::size_t first;
        std::size_t last;
    };
    void add_edge(At low, At high, double sign) noexcept;
    void add_within_row(std::size_t row, double from_x, double to_x, double height) noexcept;
    void add_inside(std::size_t row, double from_x, double to_x, double height) noexcept;
    void put(std::size_t row, std::size_t column, double area) noexcept;

    std::size_t width_ = 0;
    std::size_t begin_ = 0;
    std::size_t rows_ = 0;
    std::vector<double> steps_;  ///< what each voxel has more than its left neighbour
    std::vector<Touched> touched_;
};

}  // namespace lamella
