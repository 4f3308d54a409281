// The columns of an archive: which datasets there are, and which member of a result each holds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "lamella/result.hpp"

namespace lamella {

enum class NumberType : std::uint8_t { i8, u8, u16, i32, u32, i64, u64, f64 };

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
    NumberType number;
    std::size_t width;  ///< numbers a row
    const char* unit;
    const char* meaning;  ///< or ""
    bool optional;        ///< left out where there are no rows
    /// Rows from `first` on, as they lie in the file.
    void (*get)(const SliceResult& result, std::uint64_t first, std::span<std::byte> to);
    /// Takes rows into `result`, whose arrays are large enough: how many are in their range before one that is not. Areas
    /// are left in Contour::twice_area.low, as they lie in the file, to be compared with those of the points, and whether
    /// a layer is open in Layer::contour_count.
    std::uint64_t (*set)(SliceResult& result, std::uint64_t first, std::span<const std::byte> from);

    std::size_t row_bytes() const noexcept;
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

/// Rows of columns, wherever they come from.
class ColumnSource {
public:
    virtual std::uint64_t rows(ColumnId id) const = 0;
    /// Called from several threads at once. Throws Refused.
    virtual void fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const = 0;

protected:
    ~ColumnSource() = default;
};

/// Those of a result.
class ResultColumns final : public ColumnSource {
public:
    explicit ResultColumns(const SliceResult& result) : result_(result) {}
    std::uint64_t rows(ColumnId id) const override;
    void fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const override;

private:
    const SliceResult& result_;
};

}  // namespace lamella
