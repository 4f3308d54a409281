#include "medical/hdf5/columns.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/little_endian.hpp"

namespace lamella {

namespace {

using Index = std::uint64_t;

/// Rows of type Row: of each what Get gives.
template <class Row, class Get>
void get_rows(const SliceResult& result, Index first, std::span<std::byte> to) {
    const std::size_t count = to.size() / sizeof(Row);
    for (std::size_t i = 0; i < count; ++i) {
        const Row row = Get()(result, first + i);
        std::memcpy(to.data() + i * sizeof(Row), &row, sizeof(Row));
    }
}

/// Set tells whether a value is in its range.
template <class Row, class Set>
Index set_rows(SliceResult& result, Index first, std::span<const std::byte> from) {
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

constexpr NumberType number_type(double) {
    return NumberType::f64;
}
constexpr NumberType number_type(std::uint64_t) {
    return NumberType::u64;
}
constexpr NumberType number_type(std::int64_t) {
    return NumberType::i64;
}
constexpr NumberType number_type(std::uint32_t) {
    return NumberType::u32;
}
constexpr NumberType number_type(std::int32_t) {
    return NumberType::i32;
}
constexpr NumberType number_type(Point) {
    return NumberType::i32;
}
constexpr NumberType number_type(std::uint16_t) {
    return NumberType::u16;
}
constexpr NumberType number_type(std::uint8_t) {
    return NumberType::u8;
}
constexpr NumberType number_type(std::int8_t) {
    return NumberType::i8;
}

template <class Row, class Get, class Set>
constexpr Column column(const char* path, ColumnKind kind, const char* unit, const char* meaning, Get, Set) {
    return {path,
            kind,
            number_type(Row{}),
            std::is_same_v<Row, Point> ? 2U : 1U,
            unit,
            meaning,
            kind > ColumnKind::point,
            &get_rows<Row, Get>,
            &set_rows<Row, Set>};
}

bool on_grid(Point point) noexcept {
    return std::min(point.x, point.y) >= -grid_limit && std::max(point.x, point.y) <= grid_limit;
}

bool stored_finite(double& to, double value) noexcept {
    to = value;
    return std::isfinite(value);
}

/// Where it is on the grid.
bool stored_point(Point& to, Point value) noexcept {
    to = value;
    return on_grid(value);
}

bool stored_edge(std::uint8_t& to, std::uint8_t edge) noexcept {
    to = edge;
    return edge <= no_edge;
}

template <class T>
bool stored(T& to, T value) noexcept {
    to = value;
    return true;
}

bool stored_plane(PlaneHeight& to, std::int32_t z) noexcept {
    to = PlaneHeight(z | 1);
    return (z & 1) != 0;
}

constexpr unsigned known_flags = orientation_overruled | orientation_mixed | gap_closed | near_contour;

const std::vector<double>& heights_of(const SliceResult& result) {
    return std::get<ExplicitPlanes>(result.plan.spacing).heights_mm;
}

std::vector<double>& heights_of(SliceResult& result) {
    return std::get<ExplicitPlanes>(result.plan.spacing).heights_mm;
}

using In = const SliceResult&;
using Out = SliceResult&;

constexpr const char* grid_unit = "grid unit";

/// In the order of ColumnId.
constexpr std::array<Column, column_count> columns = {
    column<double>(
        "/layers/bottom_mm", ColumnKind::layer, "mm", "where the slab of material begins",
        [](In r, Index i) { return r.layers[i].bottom_mm; },
        [](Out r, Index i, double v) { return stored_finite(r.layers[i].bottom_mm, v); }),
    column<double>(
        "/layers/plane_mm", ColumnKind::layer, "mm", "the height asked for; of an image: from slice 0 along axis_i x axis_j",
        [](In r, Index i) { return r.layers[i].plane_mm; },
        [](Out r, Index i, double v) { return stored_finite(r.layers[i].plane_mm, v); }),
    column<double>(
        "/layers/top_mm", ColumnKind::layer, "mm", "where the slab of material ends",
        [](In r, Index i) { return r.layers[i].top_mm; },
        [](Out r, Index i, double v) { return stored_finite(r.layers[i].top_mm, v); }),
    column<std::int32_t>(
        "/layers/plane", ColumnKind::layer, grid_unit, "the height cut", [](In r, Index i) { return r.layers[i].plane.z(); },
        [](Out r, Index i, std::int32_t v) { return stored_plane(r.layers[i].plane, v); }),
    column<std::uint64_t>(
        "/layers/segments", ColumnKind::layer, "", "triangles that the plane crosses",
        [](In r, Index i) { return r.layers[i].segments; },
        [](Out r, Index i, Index v) { return stored(r.layers[i].segments, v); }),
    column<std::uint8_t>(
        "/layers/open", ColumnKind::layer, "", "1: some contour is open, so that area and centroid are not known",
        [](In r, Index i) { return static_cast<std::uint8_t>(is_open(r, r.layers[i])); },
        [](Out r, Index i, std::uint8_t v) {
            r.layers[i].contour_count = v;
            return v <= 1;
        }),
    column<std::uint64_t>(
        "/layers/first_contour", ColumnKind::layer_end, "", "of each layer, and where the last one ends",
        [](In r, Index i) { return i < r.layers.size() ? r.layers[i].first_contour : Index{r.contours.size()}; },
        [](Out r, Index i, Index v) {
            return i < r.layers.size() ? stored(r.layers[i].first_contour, v) : v == r.contours.size();
        }),
    column<std::uint64_t>(
        "/contours/first_point", ColumnKind::contour_end, "", "of each contour, and where the last one ends",
        [](In r, Index i) { return i < r.contours.size() ? r.contours[i].first_point : Index{r.points.size()}; },
        [](Out r, Index i, Index v) {
            return i < r.contours.size() ? stored(r.contours[i].first_point, v) : v == r.points.size();
        }),
    column<std::int64_t>(
        "/contours/parent", ColumnKind::contour, "", "the smallest contour around it; -1: none",
        [](In r, Index i) { return r.contours[i].parent; },
        [](Out r, Index i, std::int64_t v) { return stored(r.contours[i].parent, v); }),
    column<std::uint32_t>(
        "/contours/segments", ColumnKind::contour, "", "triangles that it comes from",
        [](In r, Index i) { return r.contours[i].segments; },
        [](Out r, Index i, std::uint32_t v) { return stored(r.contours[i].segments, v); }),
    column<std::uint8_t>(
        "/contours/role", ColumnKind::contour, "", "0 outer, 1 hole, 2 flat, 3 open: a polyline",
        [](In r, Index i) { return static_cast<std::uint8_t>(r.contours[i].role); },
        [](Out r, Index i, std::uint8_t v) {
            r.contours[i].role = static_cast<Role>(v);
            return v <= static_cast<std::uint8_t>(Role::open);
        }),
    column<std::int8_t>(
        "/contours/orientation", ColumnKind::contour, "",
        "by the facets or the fill rule: 1 counter-clockwise, -1 clockwise, 0 neither",
        [](In r, Index i) { return r.contours[i].orientation; },
        [](Out r, Index i, std::int8_t v) {
            r.contours[i].orientation = v;
            return v >= -1 && v <= 1;
        }),
    column<std::uint16_t>(
        "/contours/flags", ColumnKind::contour, "",
        "1 orientation overruled, 2 orientation mixed, 4 gap closed, 8 near contour",
        [](In r, Index i) { return r.contours[i].flags; },
        [](Out r, Index i, std::uint16_t v) {
            r.contours[i].flags = v;
            return (v & ~known_flags) == 0;
        }),
    column<std::uint32_t>(
        "/contours/part", ColumnKind::contour, "", "the mesh that it comes from; 2^32 - 1: several",
        [](In r, Index i) { return r.contours[i].part; },
        [](Out r, Index i, std::uint32_t v) {
            r.contours[i].part = v;
            return v < r.part_count || v == several_parts;
        }),
    column<double>(
        "/contours/area_mm2", ColumnKind::contour, "mm^2", "positive for outers, negative for holes, 0 for others",
        [](In r, Index i) { return stored_area(r, r.contours[i]); },
        [](Out r, Index i, double v) { return stored(r.contours[i].twice_area.low, std::bit_cast<std::uint64_t>(v)); }),
    column<Point>(
        "/points", ColumnKind::point, grid_unit, "x and y; times unit_mm of the root: mm",
        [](In r, Index i) { return r.points[i]; }, [](Out r, Index i, Point v) { return stored_point(r.points[i], v); }),
    column<std::uint32_t>(
        "/origins/triangle", ColumnKind::origin, "", "of each point: the triangle that the edge from there was cut from",
        [](In r, Index i) { return r.origins[i].triangle; },
        [](Out r, Index i, std::uint32_t v) { return stored(r.origins[i].triangle, v); }),
    column<std::uint16_t>(
        "/origins/part", ColumnKind::origin, "", "the mesh of that triangle",
        [](In r, Index i) { return r.origins[i].part; },
        [](Out r, Index i, std::uint16_t v) {
            r.origins[i].part = v;
            return v < r.part_count;
        }),
    column<std::uint8_t>(
        "/origins/edge", ColumnKind::origin, "", "the triangle's edge where the contour's edge begins; 3: none",
        [](In r, Index i) { return r.origins[i].edge; },
        [](Out r, Index i, std::uint8_t v) { return stored_edge(r.origins[i].edge, v); }),
    column<std::uint8_t>(
        "/origins/end_edge", ColumnKind::origin, "", "the triangle's edge where the contour's edge ends; 3: none",
        [](In r, Index i) { return r.origins[i].end_edge; },
        [](Out r, Index i, std::uint8_t v) { return stored_edge(r.origins[i].end_edge, v); }),
    column<std::uint64_t>(
        "/closed_gaps/layer", ColumnKind::gap, "", "where ends of open polylines were joined",
        [](In r, Index i) { return r.closed_gaps[i].layer; },
        [](Out r, Index i, Index v) {
            r.closed_gaps[i].layer = v;
            return v < r.layers.size();
        }),
    column<Point>(
        "/closed_gaps/from", ColumnKind::gap, grid_unit, "", [](In r, Index i) { return r.closed_gaps[i].from; },
        [](Out r, Index i, Point v) { return stored_point(r.closed_gaps[i].from, v); }),
    column<Point>(
        "/closed_gaps/to", ColumnKind::gap, grid_unit, "", [](In r, Index i) { return r.closed_gaps[i].to; },
        [](Out r, Index i, Point v) { return stored_point(r.closed_gaps[i].to, v); }),
    column<double>(
        "/plan/heights_mm", ColumnKind::height, "mm", "the heights asked for, in any order",
        [](In r, Index i) { return heights_of(r)[i]; },
        [](Out r, Index i, double v) { return stored_finite(heights_of(r)[i], v); }),
    column<std::uint64_t>(
        "/plan/layer_of_height", ColumnKind::height, "", "the layer of each height, among those of the plan",
        [](In r, Index i) { return r.layer_of[i]; },
        [](Out r, Index i, Index v) {
            r.layer_of[i] = v;
            return v < r.all_layers;
        }),
    column<std::uint64_t>(
        "/region/fill_from_layer", ColumnKind::fill_change, "", "from this layer of the plan on another fill rule",
        [](In r, Index i) { return r.region.fill_from[i].first_layer; },
        [](Out r, Index i, Index v) { return stored(r.region.fill_from[i].first_layer, v); }),
    column<std::uint8_t>(
        "/region/fill_from_rule", ColumnKind::fill_change, "", "0 contours, 1 even-odd, 2 non-zero, 3 positive, 4 outermost",
        [](In r, Index i) { return static_cast<std::uint8_t>(r.region.fill_from[i].rule); },
        [](Out r, Index i, std::uint8_t v) {
            r.region.fill_from[i].rule = static_cast<FillRule>(v);
            return v <= static_cast<std::uint8_t>(FillRule::outermost);
        }),
};

}  // namespace

bool is_open(const SliceResult& result, const Layer& layer) noexcept {
    return std::isnan(result.area_mm2(layer));
}

double stored_area(const SliceResult& result, const Contour& contour) noexcept {
    return result.area_mm2(contour) + 0.0;  // never -0
}

std::size_t Column::row_bytes() const noexcept {
    static constexpr std::array<std::size_t, 8> bytes = {1, 1, 2, 4, 4, 8, 8, 8};  // by NumberType
    return width * bytes[static_cast<std::size_t>(number)];
}

const Column& column_of(ColumnId id) noexcept {
    return columns[static_cast<std::size_t>(id)];
}

std::uint64_t rows_of(const SliceResult& result, ColumnKind kind) noexcept {
    switch (kind) {
        case ColumnKind::layer:
            return result.layers.size();
        case ColumnKind::layer_end:
            return result.layers.size() + 1;
        case ColumnKind::contour:
            return result.contours.size();
        case ColumnKind::contour_end:
            return result.contours.size() + 1;
        case ColumnKind::point:
            return result.points.size();
        case ColumnKind::origin:
            return result.origins.size();
        case ColumnKind::gap:
            return result.closed_gaps.size();
        case ColumnKind::height:
            return std::holds_alternative<ExplicitPlanes>(result.plan.spacing) ? heights_of(result).size() : 0;
        case ColumnKind::fill_change:
            return result.region.fill_from.size();
    }
    return 0;
}

std::uint64_t ResultColumns::rows(ColumnId id) const {
    return rows_of(result_, column_of(id).kind);
}

void ResultColumns::fill(ColumnId id, std::uint64_t first, std::span<std::byte> to) const {
    column_of(id).get(result_, first, to);
}

}  // namespace lamella
