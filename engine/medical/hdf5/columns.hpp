// The columns of an archive: which datasets there are, and which member of a result each holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <hdf5.h>

#include "lamella/result.hpp"

namespace lamella {

enum class ColumnId : std::uint8_t {
    bottom_mm,
    plane_mm,
    top_mm,
    plane,
    layer_segments,
    layer_open,
    first_contour,
    first_point,
    parent,
    segments,
    role,
    orientation,
    flags,
    part,
    area_mm2,
    points,
    origin_triangle,
    origin_part,
    origin_edge,
    origin_end_edge,
    gap_layer,
    gap_from,
    gap_to,
    heights_mm,
    layer_of_height,
    fill_from_layer,
    fill_from_rule,
};
inline constexpr std::size_t column_count = static_cast<std::size_t>(ColumnId::fill_from_rule) + 1;

/// What a column's rows belong to: columns of one kind are equally long. Those of an end have a last row more: where the
/// last layer or contour ends.
enum class ColumnKind : std::uint8_t { layer, layer_end, contour, contour_end, point, origin, gap, height, fill_change };

struct Column {
    const char* path;
    ColumnKind kind;
    hid_t (*type)();    ///< of its numbers
    std::size_t width;  ///< numbers a row
    std::size_t row_bytes;
    const char* unit;
    const char* meaning;  ///< or ""
    bool optional;        ///< left out where there are no rows
    /// Rows from `first` on, as they lie in the file.
    void (*get)(const SliceResult& result, std::uint64_t first, std::span<std::byte> to);
    /// Takes rows into `result`, whose arrays are large enough: how many are in their range before one that is not. Areas
    /// are left in Contour::twice_area.low, as they lie in the file, to be compared with those of the points, and whether
    /// a layer is open in Layer::contour_count.
    std::uint64_t (*set)(SliceResult& result, std::uint64_t first, std::span<const std::byte> from);
};

const Column& column_of(ColumnId id) noexcept;

/// As archives hold them.
bool is_open(const SliceResult& result, const Layer& layer) noexcept;
double stored_area(const SliceResult& result, const Contour& contour) noexcept;

/// How many rows of that kind a result has.
std::uint64_t rows_of(const SliceResult& result, ColumnKind kind) noexcept;

/// Calls body(id) for each.
template <class Body>
void for_each_column(Body body) {
    for (std::size_t i = 0; i < column_count; ++i) {
        body(static_cast<ColumnId>(i));
    }
}

}  // namespace lamella
