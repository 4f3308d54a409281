// The columns of an archive: which datasets there are, and which member of a result each holds.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <hdf5.h>

#include "lamella/result.hpp"

namespace lamella {

/// The things that a column has a row for: columns of one kind are equally long. Those of an end have a last row more: where
/// the last layer or contour ends.
enum class ColumnKind : std::uint8_t { layer, layer_end, contour, contour_end, point, origin, stitch, height, fill_change };

/// How many rows the columns of each kind have.
class KindRows {
public:
    std::uint64_t& operator[](ColumnKind kind) noexcept { return rows_[static_cast<std::size_t>(kind)]; }
    std::uint64_t operator[](ColumnKind kind) const noexcept { return rows_[static_cast<std::size_t>(kind)]; }

private:
    std::array<std::uint64_t, static_cast<std::size_t>(ColumnKind::fill_change) + 1> rows_{};
};

struct Column {
    const char* path;
    ColumnKind kind;
    hid_t (*type)();    ///< of its numbers
    std::size_t width;  ///< numbers a row
    std::size_t row_bytes;
    const char* unit;
    const char* meaning;  ///< or ""
    /// Rows from `first` on, as they lie in the file.
    void (*get)(const SliceResult& result, std::uint64_t first, std::span<std::byte> to);
    /// Takes rows into `result`, whose arrays are large enough: how many are in their range before one that is not. Null
    /// where all follows from other columns, and stands in the file for other programs.
    std::uint64_t (*set)(SliceResult& result, std::uint64_t first, std::span<const std::byte> from);
    std::optional<ColumnKind> names;  ///< its numbers are indices of such rows

    /// Left out where there are no rows.
    bool is_optional() const noexcept { return kind > ColumnKind::point; }
};

/// Those of one kind stand side by side.
std::span<const Column> all_columns() noexcept;

/// A column and where its rows lie in the file, one after the other.
struct PlacedColumn {
    const Column* column = nullptr;
    std::uint64_t rows = 0;
    std::uint64_t offset = 0;

    std::uint64_t bytes() const noexcept { return rows * column->row_bytes; }
};

/// Rows of a column that are worked on at once: about a MiB.
struct RowRange {
    std::uint64_t first = 0;
    std::size_t count = 0;
};
std::vector<RowRange> ranges_of(std::uint64_t rows, const Column& column);

KindRows rows_of(const SliceResult& result) noexcept;

/// Arrays of so many rows, their contents unspecified; heights only where the options have some.
void resize(SliceResult& result, const KindRows& rows);

}  // namespace lamella
