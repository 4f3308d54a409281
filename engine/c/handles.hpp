// The options of a call from C as those of C++, the contents of opaque handles, and the C structs that are views of C++
// ones: same bytes, another name.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "lamella/assemble.hpp"
#include "lamella/control.hpp"
#include "lamella/error.hpp"
#include "lamella/lamella.h"
#include "lamella/mesh.hpp"
#include "lamella/prepare.hpp"
#include "lamella/region.hpp"
#include "lamella/result.hpp"
#include "lamella/slice.hpp"

namespace lamella::c {

/// Holds what the C++ options point to: neither copied nor moved once it is filled in. Its lists keep their memory.
class CallOptions {
public:
    CallOptions() = default;
    CallOptions(const CallOptions&) = delete;
    CallOptions& operator=(const CallOptions&) = delete;

    /// From what the program gave; null: the defaults. invalid_argument where a struct has no size or a choice no meaning.
    Status read(const lamella_options* given);
    Status read_control(const lamella_control* given);
    Status read_rules(const lamella_region_rules* given);

    SliceOptions options;

private:
    Status read_plan(const lamella_options& given);

    lamella_control control_{};
};

/// `in_mm`: what brings the mesh's coordinates to mm.
Status read_mesh(const lamella_mesh* given, MeshView& view, double& in_mm);

/// For a list that is NULL though it has a length.
Error missing(const char* what);

}  // namespace lamella::c

struct lamella_result {
    lamella::SliceResult result;
};

struct lamella_workspace {
    lamella::Workspace workspace;
    lamella::c::CallOptions options;  ///< kept, so that a call allocates nothing for them
};

struct lamella_prepared {
    lamella::PreparedMesh mesh;
};

namespace lamella::c {

/// For each struct of the C header that is an element of an array, or that the library only looks at: the C++ struct that
/// lies in the same bytes.
template <class C>
struct Same;
#define LAMELLA_SAME(C, Cpp) \
    template <>              \
    struct Same<C> {         \
        using type = Cpp;    \
    };                       \
    static_assert(sizeof(C) == sizeof(Cpp))
#define LAMELLA_SAME_PLACE(C, c_field, Cpp, field) \
    static_assert(offsetof(C, c_field) == offsetof(Cpp, field), #C "." #c_field " and its C++ field lie in one place")
LAMELLA_SAME(lamella_point, Point);
LAMELLA_SAME_PLACE(lamella_point, y, Point, y);
LAMELLA_SAME(lamella_contour, Contour);
LAMELLA_SAME_PLACE(lamella_contour, twice_area_low, Contour, twice_area);
LAMELLA_SAME_PLACE(lamella_contour, parent, Contour, parent);
LAMELLA_SAME_PLACE(lamella_contour, point_count, Contour, point_count);
LAMELLA_SAME_PLACE(lamella_contour, segments, Contour, segments);
LAMELLA_SAME_PLACE(lamella_contour, role, Contour, role);
LAMELLA_SAME_PLACE(lamella_contour, orientation, Contour, orientation);
LAMELLA_SAME_PLACE(lamella_contour, flags, Contour, flags);
LAMELLA_SAME_PLACE(lamella_contour, part, Contour, part);
LAMELLA_SAME(lamella_layer, Layer);
LAMELLA_SAME_PLACE(lamella_layer, top_mm, Layer, top_mm);
LAMELLA_SAME_PLACE(lamella_layer, first_contour, Layer, first_contour);
LAMELLA_SAME_PLACE(lamella_layer, segments, Layer, segments);
LAMELLA_SAME_PLACE(lamella_layer, plane, Layer, plane);
LAMELLA_SAME(lamella_closed_gap, ClosedGap);
LAMELLA_SAME_PLACE(lamella_closed_gap, from, ClosedGap, from);
LAMELLA_SAME_PLACE(lamella_closed_gap, to, ClosedGap, to);
LAMELLA_SAME(lamella_point_origin, PointOrigin);
LAMELLA_SAME_PLACE(lamella_point_origin, part, PointOrigin, part);
LAMELLA_SAME_PLACE(lamella_point_origin, edge, PointOrigin, edge);
LAMELLA_SAME_PLACE(lamella_point_origin, end_edge, PointOrigin, end_edge);
static_assert(LAMELLA_NO_TRIANGLE == no_triangle && LAMELLA_NO_EDGE == no_edge && LAMELLA_SEVERAL_PARTS == several_parts);
static_assert(LAMELLA_DEFAULT_UNIT_MM == default_unit_mm && LAMELLA_UNIT_BY_BOX == unit_by_box &&
              LAMELLA_GAPS_BY_MESH == gaps_by_mesh && LAMELLA_GRID_LIMIT == grid_limit);
LAMELLA_SAME(lamella_segment, Segment);
LAMELLA_SAME_PLACE(lamella_segment, to_key, Segment, to_key);
LAMELLA_SAME_PLACE(lamella_segment, from, Segment, from);
LAMELLA_SAME_PLACE(lamella_segment, from_rank, Segment, from_rank);
LAMELLA_SAME(lamella_memory, Memory);
LAMELLA_SAME_PLACE(lamella_memory, release, Memory, release);
LAMELLA_SAME_PLACE(lamella_memory, context, Memory, context);
#undef LAMELLA_SAME
#undef LAMELLA_SAME_PLACE

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

/// The counts and the box that views and totals of a result have in common.
template <class C>
void copy_summary(const SliceSummary& summary, C& c) noexcept {
    c.unit_doublings = static_cast<std::int32_t>(summary.unit_doublings);
    c.triangles = summary.triangles;
    c.degenerate = summary.degenerate;
    c.segments = summary.segments;
    c.holes = summary.holes;
    c.open_contours = summary.open_contours;
    c.flat_contours = summary.flat_contours;
    c.overruled_contours = summary.overruled_contours;
    c.near_contours = summary.near_contours;
    c.emptied_layers = summary.emptied_layers;
    std::copy(std::begin(summary.min_mm), std::end(summary.min_mm), c.min_mm);
    std::copy(std::begin(summary.max_mm), std::end(summary.max_mm), c.max_mm);
}

}  // namespace lamella::c
