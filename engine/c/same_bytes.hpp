// C structs that are views of C++ ones: same bytes, another name. And the constants that both state.
#pragma once

#include <cstddef>
#include <type_traits>

#include "lamella/context.hpp"
#include "lamella/grid.hpp"
#include "lamella/lamella.h"
#include "lamella/layers.hpp"
#include "lamella/options.hpp"
#include "lamella/result.hpp"

namespace lamella::c {

/// For each struct of the C header that is an element of an array: the C++ struct that lies in the same bytes.
template <class C>
struct Same;
#define LAMELLA_SAME(C, Cpp)                                   \
    template <>                                                \
    struct Same<C> {                                           \
        using type = Cpp;                                      \
        static_assert(sizeof(C) == sizeof(Cpp), "same bytes"); \
    }
LAMELLA_SAME(lamella_point, Point);
LAMELLA_SAME(lamella_contour, Contour);
LAMELLA_SAME(lamella_layer, Layer);
LAMELLA_SAME(lamella_stitch, Stitch);
LAMELLA_SAME(lamella_point_origin, PointOrigin);
LAMELLA_SAME(lamella_segment, Segment);
LAMELLA_SAME(lamella_memory, Memory);
#undef LAMELLA_SAME

#define LAMELLA_SAME_PLACE(C, c_field, Cpp, field) \
    static_assert(offsetof(C, c_field) == offsetof(Cpp, field), #C "." #c_field " and its C++ field lie in one place")
LAMELLA_SAME_PLACE(lamella_point, y, Point, y);
LAMELLA_SAME_PLACE(lamella_contour, twice_area_low, Contour, twice_area);
LAMELLA_SAME_PLACE(lamella_contour, parent, Contour, parent);
LAMELLA_SAME_PLACE(lamella_contour, point_count, Contour, point_count);
LAMELLA_SAME_PLACE(lamella_contour, segments, Contour, segments);
LAMELLA_SAME_PLACE(lamella_contour, role, Contour, role);
LAMELLA_SAME_PLACE(lamella_contour, orientation, Contour, orientation);
LAMELLA_SAME_PLACE(lamella_contour, flags, Contour, flags);
LAMELLA_SAME_PLACE(lamella_contour, part, Contour, part);
LAMELLA_SAME_PLACE(lamella_layer, top_mm, Layer, top_mm);
LAMELLA_SAME_PLACE(lamella_layer, first_contour, Layer, first_contour);
LAMELLA_SAME_PLACE(lamella_layer, segments, Layer, segments);
LAMELLA_SAME_PLACE(lamella_layer, plane, Layer, plane);
LAMELLA_SAME_PLACE(lamella_stitch, from, Stitch, from);
LAMELLA_SAME_PLACE(lamella_stitch, to, Stitch, to);
LAMELLA_SAME_PLACE(lamella_point_origin, part, PointOrigin, part);
LAMELLA_SAME_PLACE(lamella_point_origin, edge, PointOrigin, edge);
LAMELLA_SAME_PLACE(lamella_point_origin, end_edge, PointOrigin, end_edge);
LAMELLA_SAME_PLACE(lamella_segment, to_key, Segment, to_key);
LAMELLA_SAME_PLACE(lamella_segment, from, Segment, from);
LAMELLA_SAME_PLACE(lamella_segment, from_rank, Segment, from_rank);
static_assert(std::is_standard_layout_v<Memory>);
LAMELLA_SAME_PLACE(lamella_memory, release_object, Memory, release);
#undef LAMELLA_SAME_PLACE
static_assert(LAMELLA_NO_TRIANGLE == no_triangle && LAMELLA_NO_EDGE == no_edge && LAMELLA_SEVERAL_PARTS == several_parts);
static_assert(LAMELLA_DEFAULT_GRID_MM == default_grid_mm && LAMELLA_FINEST_GRID == finest_grid &&
              LAMELLA_STITCH_BY_MESH == stitch_by_mesh && LAMELLA_GRID_LIMIT == grid_limit &&
              LAMELLA_ALL_LAYERS == all_layers);

template <class C>
const typename Same<C>::type* as_cpp(const C* c) noexcept {
    return reinterpret_cast<const typename Same<C>::type*>(c);
}
template <class C>
typename Same<C>::type* as_cpp(C* c) noexcept {
    return reinterpret_cast<typename Same<C>::type*>(c);
}
template <class C>
const C* as_c(const typename Same<C>::type* cpp) noexcept {
    return reinterpret_cast<const C*>(cpp);
}

}  // namespace lamella::c
