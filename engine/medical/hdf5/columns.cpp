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
#include "medical/hdf5/handles.hpp"

namespace lamella {

namespace {

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

/// Set tells whether a value is in its range.
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

template <class Row, class Get, class Set>
constexpr Column column(const char* path, ColumnKind kind, const char* unit, const char* meaning, Get, Set) {
    constexpr bool is_point = std::is_same_v<Row, Point>;
    return {path,
            kind,
            &hdf5_type<std::conditional_t<is_point, std::int32_t, Row>>,
            is_point ? 2U : 1U,
            sizeof(Row),
            unit,
            meaning,
            kind > ColumnKind::point,
            std::nullopt,
            &get_rows<Row, Get>,
            &set_rows<Row, Set>};
}

/// A column of what Member refers to; Good tells whether a value is in its range.
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

constexpr unsigned known_flags = orientation_overruled | orientation_mixed | gap_closed | near_contour;

constexpr auto any = [](In, auto) { return true; };
constexpr auto finite = [](In, double value) { return std::isfinite(value); };
constexpr auto known_edge = [](In, std::uint8_t edge) { return edge <= no_edge; };
constexpr auto on_grid = [](In, Point point) {
    return std::min(point.x, point.y) >= -grid_limit && std::max(point.x, point.y) <= grid_limit;
};

template <class Result>
auto& heights_of(Result& result) {
    return std::get<ExplicitPlanes>(result.plan.spacing).heights_mm;
}

constexpr const char* grid_unit = "grid unit";

constexpr std::array columns = {
    member<double>(
        "/layers/bottom_mm", ColumnKind::layer, "mm", "where the slab of material begins",
        [](auto& r, Index i) -> auto& { return r.layers[i].bottom_mm; }, finite),
    member<double>(
        "/layers/plane_mm", ColumnKind::layer, "mm", "the height asked for; of an image: from slice 0 along axis_i x axis_j",
        [](auto& r, Index i) -> auto& { return r.layers[i].plane_mm; }, finite),
    member<double>(
        "/layers/top_mm", ColumnKind::layer, "mm", "where the slab of material ends",
        [](auto& r, Index i) -> auto& { return r.layers[i].top_mm; }, finite),
    column<std::int32_t>(
        "/layers/plane", ColumnKind::layer, grid_unit, "the height cut", [](In r, Index i) { return r.layers[i].plane.z(); },
        [](Out r, Index i, std::int32_t z) {
            r.layers[i].plane = PlaneHeight(z | 1);
            return (z & 1) != 0;
        }),
    member<std::uint64_t>(
        "/layers/segments", ColumnKind::layer, "", "triangles that the plane crosses",
        [](auto& r, Index i) -> auto& { return r.layers[i].segments; }, any),
    column<std::uint8_t>(
        "/layers/open", ColumnKind::layer, "", "1: some contour is open, so that area and centroid are not known",
        [](In r, Index i) { return is_open(r, r.layers[i]); },
        [](Out r, Index i, std::uint8_t v) {
            r.layers[i].contour_count = v;
            return v <= 1;
        }),
    naming(ColumnKind::contour,
           column<std::uint64_t>(
               "/layers/first_contour", ColumnKind::layer_end, "", "of each layer, and where the last one ends",
               [](In r, Index i) { return i < r.layers.size() ? r.layers[i].first_contour : Index{r.contours.size()}; },
               [](Out r, Index i, Index v) {
                   if (i == r.layers.size()) {
                       return v == r.contours.size();
                   }
                   r.layers[i].first_contour = v;
                   return true;
               })),
    naming(ColumnKind::point,
           column<std::uint64_t>(
               "/contours/first_point", ColumnKind::contour_end, "", "of each contour, and where the last one ends",
               [](In r, Index i) { return i < r.contours.size() ? r.contours[i].first_point : Index{r.points.size()}; },
               [](Out r, Index i, Index v) {
                   if (i == r.contours.size()) {
                       return v == r.points.size();
                   }
                   r.contours[i].first_point = v;
                   return true;
               })),
    naming(ColumnKind::contour, member<std::int64_t>(
                                    "/contours/parent", ColumnKind::contour, "", "the smallest contour around it; -1: none",
                                    [](auto& r, Index i) -> auto& { return r.contours[i].parent; }, any)),
    member<std::uint32_t>(
        "/contours/segments", ColumnKind::contour, "", "triangles that it comes from",
        [](auto& r, Index i) -> auto& { return r.contours[i].segments; }, any),
    member<std::uint8_t>(
        "/contours/role", ColumnKind::contour, "", "0 outer, 1 hole, 2 flat, 3 open: a polyline",
        [](auto& r, Index i) -> auto& { return r.contours[i].role; },
        [](In, std::uint8_t v) { return v <= static_cast<std::uint8_t>(Role::open); }),
    member<std::int8_t>(
        "/contours/orientation", ColumnKind::contour, "",
        "by the facets or the fill rule: 1 counter-clockwise, -1 clockwise, 0 neither",
        [](auto& r, Index i) -> auto& { return r.contours[i].orientation; },
        [](In, std::int8_t v) { return v >= -1 && v <= 1; }),
    member<std::uint16_t>(
        "/contours/flags", ColumnKind::contour, "",
        "1 orientation overruled, 2 orientation mixed, 4 gap closed, 8 near contour",
        [](auto& r, Index i) -> auto& { return r.contours[i].flags; },
        [](In, std::uint16_t v) { return (v & ~known_flags) == 0; }),
    member<std::uint32_t>(
        "/contours/part", ColumnKind::contour, "", "the mesh that it comes from; 2^32 - 1: several",
        [](auto& r, Index i) -> auto& { return r.contours[i].part; },
        [](In r, std::uint32_t v) { return v < r.part_count || v == several_parts; }),
    column<double>(
        "/contours/area_mm2", ColumnKind::contour, "mm^2", "positive for outers, negative for holes, 0 for others",
        [](In r, Index i) { return stored_area(r, r.contours[i]); },
        [](Out r, Index i, double v) {
            r.contours[i].twice_area.low = std::bit_cast<std::uint64_t>(v);
            return true;
        }),
    member<Point>(
        "/points", ColumnKind::point, grid_unit, "x and y; times unit_mm of the root: mm",
        [](auto& r, Index i) -> auto& { return r.points[i]; }, on_grid),
    member<std::uint32_t>(
        "/origins/triangle", ColumnKind::origin, "", "of each point: the triangle that the edge from there was cut from",
        [](auto& r, Index i) -> auto& { return r.origins[i].triangle; }, any),
    member<std::uint16_t>(
        "/origins/part", ColumnKind::origin, "", "the mesh of that triangle",
        [](auto& r, Index i) -> auto& { return r.origins[i].part; }, [](In r, std::uint16_t v) { return v < r.part_count; }),
    member<std::uint8_t>(
        "/origins/edge", ColumnKind::origin, "", "the triangle's edge where the contour's edge begins; 3: none",
        [](auto& r, Index i) -> auto& { return r.origins[i].edge; }, known_edge),
    member<std::uint8_t>(
        "/origins/end_edge", ColumnKind::origin, "", "the triangle's edge where the contour's edge ends; 3: none",
        [](auto& r, Index i) -> auto& { return r.origins[i].end_edge; }, known_edge),
    naming(ColumnKind::layer, member<std::uint64_t>(
                                  "/closed_gaps/layer", ColumnKind::gap, "", "where ends of open polylines were joined",
                                  [](auto& r, Index i) -> auto& { return r.closed_gaps[i].layer; },
                                  [](In r, Index v) { return v < r.layers.size(); })),
    member<Point>(
        "/closed_gaps/from", ColumnKind::gap, grid_unit, "", [](auto& r, Index i) -> auto& { return r.closed_gaps[i].from; },
        on_grid),
    member<Point>(
        "/closed_gaps/to", ColumnKind::gap, grid_unit, "", [](auto& r, Index i) -> auto& { return r.closed_gaps[i].to; },
        on_grid),
    member<double>(
        "/plan/heights_mm", ColumnKind::height, "mm", "the heights asked for, in any order",
        [](auto& r, Index i) -> auto& { return heights_of(r)[i]; }, finite),
    member<std::uint64_t>(
        "/plan/layer_of_height", ColumnKind::height, "", "the layer of each height, among those of the plan",
        [](auto& r, Index i) -> auto& { return r.layer_of[i]; }, [](In r, Index v) { return v < r.all_layers; }),
    member<std::uint64_t>(
        "/region/fill_from_layer", ColumnKind::fill_change, "", "from this layer of the plan on another fill rule",
        [](auto& r, Index i) -> auto& { return r.region.fill_from[i].first_layer; }, any),
    member<std::uint8_t>(
        "/region/fill_from_rule", ColumnKind::fill_change, "", "0 contours, 1 even-odd, 2 non-zero, 3 positive, 4 outermost",
        [](auto& r, Index i) -> auto& { return r.region.fill_from[i].rule; },
        [](In, std::uint8_t v) { return v <= static_cast<std::uint8_t>(FillRule::outermost); }),
};

}  // namespace

bool is_open(const SliceResult& result, const Layer& layer) noexcept {
    return std::isnan(result.area_mm2(layer));
}

double stored_area(const SliceResult& result, const Contour& contour) noexcept {
    return result.area_mm2(contour) + 0.0;  // never -0
}

std::span<const Column> all_columns() noexcept {
    return columns;
}

KindRows rows_of(const SliceResult& result) noexcept {
    KindRows rows;
    rows[ColumnKind::layer] = result.layers.size();
    rows[ColumnKind::layer_end] = result.layers.size() + 1;
    rows[ColumnKind::contour] = result.contours.size();
    rows[ColumnKind::contour_end] = result.contours.size() + 1;
    rows[ColumnKind::point] = result.points.size();
    rows[ColumnKind::origin] = result.origins.size();
    rows[ColumnKind::gap] = result.closed_gaps.size();
    rows[ColumnKind::height] = std::holds_alternative<ExplicitPlanes>(result.plan.spacing) ? heights_of(result).size() : 0;
    rows[ColumnKind::fill_change] = result.region.fill_from.size();
    return rows;
}

}  // namespace lamella
