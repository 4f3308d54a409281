// The columns of an archive: which datasets there are, and which member of a result each holds.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <tuple>
#include <type_traits>
#include <vector>

#include <hdf5.h>

#include "base/little_endian.hpp"
#include "lamella/measures.hpp"
#include "lamella/result.hpp"

namespace lamella {

using NumberType = hid_t (*)();

/// Little-endian, as hosts are.
template <class Number>
hid_t hdf5_type() {
    if constexpr (std::is_same_v<Number, double>) {
        return H5T_IEEE_F64LE;
    } else {
        const std::array<hid_t, 4> types = std::is_signed_v<Number>
                                               ? std::array{H5T_STD_I8LE, H5T_STD_I16LE, H5T_STD_I32LE, H5T_STD_I64LE}
                                               : std::array{H5T_STD_U8LE, H5T_STD_U16LE, H5T_STD_U32LE, H5T_STD_U64LE};
        return types[static_cast<std::size_t>(std::countr_zero(sizeof(Number)))];
    }
}

/// The things that a column has a row for: columns of one kind are equally long.
enum ColumnKind : std::uint8_t {
    layer_rows,
    contour_rows,
    point_rows,
    origin_rows,
    stitch_rows,
    height_rows,
    slab_rows,
    fill_change_rows,
    measure_rows
};

/// How many rows the columns of each kind have.
using KindRows = std::array<std::uint64_t, measure_rows + 1>;

struct Column {
    const char* path;
    ColumnKind kind;
    NumberType type;
    std::size_t width;  ///< numbers a row
    std::size_t row_bytes;
    const char* unit;
    const char* meaning;  ///< or ""
    /// Rows from `first` on, as they lie in the file.
    void (*get)(const SliceResult& result, std::uint64_t first, std::span<std::byte> to);
    /// Takes rows into `result`, whose arrays are large enough: how many are in their range before one that is not. Null
    /// where all follows from other columns, and stands in the file for other programs.
    std::uint64_t (*set)(SliceResult& result, std::uint64_t first, std::span<const std::byte> from) = nullptr;
    std::optional<ColumnKind> names = std::nullopt;  ///< its numbers are indices of such rows
    bool has_end = false;                            ///< a last row tells where the last layer or contour ends
    /// Of a column of measures, which stand in the file for other programs: a value of a row.
    double (*measured)(const SectionMeasures& of) = nullptr;

    /// Left out where there are no rows.
    bool is_optional() const noexcept { return kind > point_rows; }
    std::uint64_t rows_among(const KindRows& rows) const noexcept { return rows[kind] + (has_end ? 1 : 0); }
};

namespace columns {

using Index = std::uint64_t;
using In = const SliceResult&;
using Out = SliceResult&;

/// Rows of type Row: of each what Get gives.
template <class Row, class Get>
void get_rows(In result, Index first, std::span<std::byte> to) {
    const std::size_t count = to.size() / sizeof(Row);
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<Row>(Get()(result, first + i));
        std::memcpy(to.data() + i * sizeof(Row), &row, sizeof(Row));
    }
}

/// Set says whether a value is in its range.
template <class Row, class Set>
Index set_rows(Out result, Index first, std::span<const std::byte> from) {
    const std::size_t count = from.size() / sizeof(Row);
    for (std::size_t i = 0; i < count; ++i) {
        Row row;
        std::memcpy(&row, from.data() + i * sizeof(Row), sizeof(Row));
        if (!Set()(result, first + i, row)) {
            return i;
        }
    }
    return count;
}

/// A column of what Get gives. Set takes a value and returns whether it is in its range; null for what is only written.
template <class Row, class Get, class Set>
constexpr Column column(const char* path, ColumnKind kind, const char* unit, const char* meaning, Get, Set) {
    constexpr bool is_point = std::is_same_v<Row, Point>;
    using Number = std::conditional_t<is_point, std::int32_t, Row>;
    Column made{path, kind, &hdf5_type<Number>, is_point ? 2U : 1U, sizeof(Row), unit, meaning, &get_rows<Row, Get>};
    if constexpr (!std::is_null_pointer_v<Set>) {
        made.set = &set_rows<Row, Set>;
    }
    return made;
}

/// A column of what Member refers to; Good says whether a value is in its range.
template <class Row, class Member, class Good>
constexpr Column member(const char* path, ColumnKind kind, const char* unit, const char* meaning, Member get, Good) {
    const auto set = [](Out result, Index i, Row row) {
        auto& to = Member()(result, i);
        to = static_cast<std::remove_reference_t<decltype(to)>>(row);
        return Good()(result, row);
    };
    return column<Row>(path, kind, unit, meaning, get, set);
}

/// The same, its numbers being indices of rows of that kind.
constexpr Column naming(ColumnKind kind, Column column) {
    column.names = kind;
    return column;
}

/// Where the items of each row begin, and where the last ones end.
template <auto rows, auto first, auto items>
constexpr Column begins(const char* path, ColumnKind kind, ColumnKind names, const char* meaning) {
    const auto get = [](In r, Index i) { return i < (r.*rows).size() ? (r.*rows)[i].*first : Index{(r.*items).size()}; };
    const auto set = [](Out r, Index i, Index value) {
        if (i == (r.*rows).size()) {
            return value == (r.*items).size();
        }
        (r.*rows)[i].*first = value;
        return true;
    };
    Column made = naming(names, column<Index>(path, kind, "", meaning, get, set));
    made.has_end = true;
    return made;
}

constexpr auto any = [](In, auto) { return true; };
constexpr auto finite = [](In, double value) { return std::isfinite(value); };
template <unsigned largest>
constexpr auto at_most = [](In, auto value) { return value <= largest; };
constexpr auto on_grid = [](In, Point point) {
    return std::min(point.x, point.y) >= -grid_limit && std::max(point.x, point.y) <= grid_limit;
};

constexpr const char* grid_unit = "grid unit";

// A column of what `place` of the result `r` is in row `i`.
#define MEMBER(path, kind, Row, unit, meaning, place, good) \
    member<Row>(                                            \
        path, kind##_rows, unit, meaning, [](auto& r, Index i) -> auto& { return r.place; }, good)

/// A column of measures, where results have none.
constexpr Column measure(const char* path, const char* unit, double (*get)(const SectionMeasures& of)) {
    Column made{path, measure_rows, &hdf5_type<double>, 1, sizeof(double), unit, "as in tables; NaN: not known", nullptr};
    made.measured = get;
    return made;
}
#define MEASURE(name, unit, place) \
    measure("/measures/" name, unit, [](const SectionMeasures& of) -> double { return static_cast<double>(of.place); })

/// Those of one kind stand side by side.
constexpr std::array all = {
    MEMBER("/layers/bottom_mm", layer, double, "mm", "where the slab of material begins", layers[i].bottom_mm, finite),
    MEMBER("/layers/plane_mm", layer, double, "mm", "the height asked for; of an image: from slice 0 along axis_i x axis_j",
           layers[i].plane_mm, finite),
    MEMBER("/layers/top_mm", layer, double, "mm", "where the slab of material ends", layers[i].top_mm, finite),
    column<std::int32_t>(
        "/layers/plane", layer_rows, grid_unit, "the height cut", [](In r, Index i) { return r.layers[i].plane.z(); },
        [](Out r, Index i, std::int32_t z) {
            r.layers[i].plane = PlaneHeight(z | 1);
            return (z & 1) != 0;
        }),
    MEMBER("/layers/segments", layer, std::uint64_t, "", "triangles that the plane crosses", layers[i].segments, any),
    column<std::uint8_t>(
        "/layers/open", layer_rows, "", "1: some contour is open, so that area and centroid are not known",
        [](In r, Index i) { return std::isnan(r[i].area_mm2()); }, nullptr),
    begins<&SliceResult::layers, &Layer::first_contour, &SliceResult::contours>(
        "/layers/first_contour", layer_rows, contour_rows, "of each layer, and where the last one ends"),
    begins<&SliceResult::contours, &Contour::first_point, &SliceResult::points>(
        "/contours/first_point", contour_rows, point_rows, "of each contour, and where the last one ends"),
    naming(contour_rows, MEMBER("/contours/parent", contour, std::int64_t, "", "the smallest contour around it; -1: none",
                                contours[i].parent, any)),
    MEMBER("/contours/segments", contour, std::uint32_t, "", "triangles that it comes from", contours[i].segments, any),
    MEMBER("/contours/role", contour, std::uint8_t, "", "0 outer, 1 hole, 2 flat, 3 open: a polyline", contours[i].role,
           at_most<static_cast<int>(Role::open)>),
    MEMBER("/contours/orientation", contour, std::int8_t, "",
           "by the facets or the fill rule: 1 counter-clockwise, -1 clockwise, 0 neither", contours[i].orientation,
           [](In, std::int8_t v) { return v >= -1 && v <= 1; }),
    MEMBER("/contours/flags", contour, std::uint16_t, "",
           "1 orientation overruled, 2 orientation mixed, 4 stitched, 8 would close", contours[i].flags,
           at_most<orientation_overruled + orientation_mixed + stitched + would_close>),
    MEMBER("/contours/part", contour, std::uint32_t, "", "the mesh that it comes from; 2^32 - 1: several", contours[i].part,
           [](In r, std::uint32_t v) { return v < r.info.part_count || v == several_parts; }),
    column<double>(
        "/contours/area_mm2", contour_rows, "mm^2", "positive for outers, negative for holes, 0 for others",
        [](In r, Index i) {
            LayerView view;
            view.grid_mm = r.info.grid_mm;
            return view.area_mm2(r.contours[i]) + 0.0;  // never -0
        },
        nullptr),
    MEMBER("/points", point, Point, grid_unit, "x and y; times grid_mm of the root: mm", points[i], on_grid),
    MEMBER("/origins/triangle", origin, std::uint32_t, "",
           "of each point: the triangle that the edge from there was cut from", origins[i].triangle, any),
    MEMBER("/origins/part", origin, std::uint16_t, "", "the mesh of that triangle", origins[i].part,
           [](In r, std::uint16_t v) { return v < r.info.part_count; }),
    MEMBER("/origins/edge", origin, std::uint8_t, "", "the triangle's edge where the contour's edge begins; 3: none",
           origins[i].edge, at_most<no_edge>),
    MEMBER("/origins/end_edge", origin, std::uint8_t, "", "the triangle's edge where the contour's edge ends; 3: none",
           origins[i].end_edge, at_most<no_edge>),
    naming(layer_rows, MEMBER("/stitches/layer", stitch, std::uint64_t, "", "where ends of open polylines were joined",
                              stitches[i].layer, [](In r, Index v) { return v < r.layers.size(); })),
    MEMBER("/stitches/from", stitch, Point, grid_unit, "", stitches[i].from, on_grid),
    MEMBER("/stitches/to", stitch, Point, grid_unit, "", stitches[i].to, on_grid),
    MEMBER("/options/heights_mm", height, double, "mm", "the heights asked for, in any order",
           info.options.heights_mm.value()[i], finite),
    MEMBER("/options/layer_of_height", height, std::uint64_t, "", "the layer of each height, among those of the plan",
           info.layer_of[i], [](In r, Index v) { return v < r.info.planned_layers; }),
    MEMBER("/options/slab_bottom_mm", slab, double, "mm", "the slab asked for of each height",
           info.options.slabs[i].bottom_mm, finite),
    MEMBER("/options/slab_top_mm", slab, double, "mm", "", info.options.slabs[i].top_mm, finite),
    MEMBER("/options/fill_from_layer", fill_change, std::uint64_t, "", "from this layer of the plan on another fill rule",
           info.options.region.fill_from[i].first_layer, any),
    MEMBER("/options/fill_from_rule", fill_change, std::uint8_t, "",
           "0 contours, 1 even-odd, 2 non-zero, 3 positive, 4 outermost", info.options.region.fill_from[i].rule,
           at_most<static_cast<int>(FillRule::outermost)>),
    MEASURE("area_mm2", "mm^2", area_mm2),
    MEASURE("perimeter_mm", "mm", perimeter_mm),
    MEASURE("islands", "", islands),
    MEASURE("holes", "", holes),
    MEASURE("open", "", open),
    MEASURE("centroid_x_mm", "mm", centroid_mm[0]),
    MEASURE("centroid_y_mm", "mm", centroid_mm[1]),
    MEASURE("outer_area_mm2", "mm^2", outer_area_mm2),
    MEASURE("outer_perimeter_mm", "mm", outer_perimeter_mm),
    MEASURE("ix_mm4", "mm^4", ix_mm4),
    MEASURE("iy_mm4", "mm^4", iy_mm4),
    MEASURE("ixy_mm4", "mm^4", ixy_mm4),
    MEASURE("imin_mm4", "mm^4", imin_mm4),
    MEASURE("imax_mm4", "mm^4", imax_mm4),
    MEASURE("angle_rad", "rad", angle_rad),
    MEASURE("polar_mm4", "mm^4", polar_mm4),
    MEASURE("feret_max_mm", "mm", feret_max_mm),
    MEASURE("feret_min_mm", "mm", feret_min_mm),
    MEASURE("feret_angle_rad", "rad", feret_angle_rad),
    MEASURE("equivalent_diameter_mm", "mm", equivalent_diameter_mm),
    MEASURE("circularity", "", circularity),
};
#undef MEMBER
#undef MEASURE

}  // namespace columns

/// Rows of a column that are worked on at once: about a MiB.
struct RowRange {
    std::uint64_t first = 0;
    std::size_t count = 0;
};
inline std::vector<RowRange> ranges_of(std::uint64_t rows, const Column& column) {
    const std::uint64_t at_once = (std::uint64_t{1} << 20) / column.row_bytes;
    std::vector<RowRange> ranges;
    for (std::uint64_t first = 0; first < rows; first += at_once) {
        ranges.push_back({first, static_cast<std::size_t>(std::min(at_once, rows - first))});
    }
    return ranges;
}

inline KindRows rows_of(const SliceResult& result) noexcept {
    const SliceOptions& options = result.info.options;
    return {result.layers.size(),  result.contours.size(),          result.points.size(),
            result.origins.size(), result.stitches.size(),          options.heights_mm ? options.heights_mm->size() : 0,
            options.slabs.size(),  options.region.fill_from.size(), 0};
}

/// What the columns of options hold.
inline auto option_columns(const SliceInfo& info) noexcept {
    return std::tie(info.options.heights_mm, info.layer_of, info.options.slabs, info.options.region.fill_from);
}

/// Arrays of so many rows, their contents unspecified; heights only where the options have some.
inline void resize(SliceResult& result, const KindRows& rows) {
    SliceOptions& options = result.info.options;
    result.layers.resize_discarding(rows[layer_rows]);
    result.contours.resize_discarding(rows[contour_rows]);
    result.points.resize_discarding(rows[point_rows]);
    result.origins.resize_discarding(rows[origin_rows]);
    result.stitches.resize_discarding(rows[stitch_rows]);
    options.slabs.resize(rows[slab_rows]);
    options.region.fill_from.resize(rows[fill_change_rows]);
    if (options.heights_mm) {
        options.heights_mm->resize(rows[height_rows]);
        result.info.layer_of.resize(rows[height_rows]);
    }
}

}  // namespace lamella
