// The paper's contour construction by a sweep line, with CGAL. CGAL's arrangement sweeps the segments once, with exact
// constructions, and records which of them meet in a vertex. Contours are then walked along unused edges. O((m + p) log
// m).
//
// Segments of thin walls can cross after rounding. They are split at the crossing, which is rounded; segments that lie
// on each other become one. Open polylines begin at vertices of odd degree, so these are walked first. Segments of no
// length after rounding are dropped.
#include "methods.hpp"

#include <cmath>

#include <CGAL/Arr_extended_dcel.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

namespace lamella::baselines {

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Traits = CGAL::Arr_segment_traits_2<Kernel>;
struct Nothing {};
/// The flag of an edge says that a contour already uses it.
using Arrangement = CGAL::Arrangement_2<Traits, CGAL::Arr_extended_dcel<Traits, Nothing, bool, Nothing>>;

Point rounded(const Kernel::Point_2& point) {
    return {static_cast<std::int32_t>(std::lround(CGAL::to_double(point.x()))),
            static_cast<std::int32_t>(std::lround(CGAL::to_double(point.y())))};
}

/// An unused edge that leaves the vertex, or none.
Arrangement::Halfedge_handle next_edge(Arrangement::Vertex_handle vertex) {
    auto around = vertex->incident_halfedges();
    const auto first = around;
    do {
        if (!around->data()) {
            return around->twin();
        }
    } while (++around != first);
    return {};
}

/// Walks unused edges from the vertex on, back to the vertex if they lead there.
Polyline walk(Arrangement::Vertex_handle start) {
    Polyline polyline;
    Arrangement::Vertex_handle at = start;
    for (auto edge = next_edge(at); edge != Arrangement::Halfedge_handle(); edge = next_edge(at)) {
        edge->set_data(true);
        edge->twin()->set_data(true);
        polyline.points.push_back(rounded(at->point()));
        at = edge->target();
        if (at == start) {
            polyline.closed = true;
            return polyline;
        }
    }
    polyline.points.push_back(rounded(at->point()));
    return polyline;
}

Arrangement arrangement_of(const std::vector<Segment>& segments) {
    std::vector<Traits::Curve_2> curves;
    curves.reserve(segments.size());
    for (const auto& [from, to] : segments) {
        if (from != to) {
            curves.emplace_back(Kernel::Point_2(from.x, from.y), Kernel::Point_2(to.x, to.y));
        }
    }
    Arrangement arrangement;
    CGAL::insert(arrangement, curves.begin(), curves.end());
    for (auto edge = arrangement.halfedges_begin(); edge != arrangement.halfedges_end(); ++edge) {
        edge->set_data(false);
    }
    return arrangement;
}

std::vector<Polyline> join_plane(const std::vector<Segment>& segments) {
    Arrangement arrangement = arrangement_of(segments);
    std::vector<Polyline> polylines;
    for (const bool odd : {true, false}) {
        for (auto vertex = arrangement.vertices_begin(); vertex != arrangement.vertices_end(); ++vertex) {
            while ((!odd || vertex->degree() % 2 == 1) && next_edge(vertex) != Arrangement::Halfedge_handle()) {
                polylines.push_back(walk(vertex));
            }
        }
    }
    return polylines;
}

}  // namespace

const ContourMethod sweepline_contours{.name = "sweep-line", .join_plane = join_plane};

}  // namespace lamella::baselines
