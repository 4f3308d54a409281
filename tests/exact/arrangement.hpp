// CGAL's arrangement of edges of two kinds at once, with the winding numbers of its faces by each kind.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include <CGAL/Arr_curve_data_traits_2.h>
#include <CGAL/Arr_extended_dcel.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include "regions/region.hpp"

namespace exact {

/// Which contours an edge belongs to.
enum Kind : std::size_t { given, found };

/// Numbers of the edges that run along a part, ascending.
using Along = std::vector<std::uint32_t>;

struct MergeAlong {
    Along operator()(const Along& a, const Along& b) const {
        Along both;
        std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
        return both;
    }
};

struct FaceData {
    bool reached = false;
    std::int64_t winding[2] = {0, 0};
    std::size_t solid = 0;  // 0: none
};

using ArrangementKernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Traits = CGAL::Arr_curve_data_traits_2<CGAL::Arr_segment_traits_2<ArrangementKernel>, Along, MergeAlong>;
using Arrangement = CGAL::Arrangement_2<Traits, CGAL::Arr_face_extended_dcel<Traits, FaceData>>;
using Halfedge = Arrangement::Halfedge_handle;
using Face = Arrangement::Face_handle;
using Corner = ArrangementKernel::Point_2;
using Edges = std::vector<std::pair<Corner, Corner>>;

Edges edges_of(const regions::Polygons& polygons);

/// To the last bit: CGAL::to_double() of a number that is not yet computed exactly may be off by 1e-5 of it.
inline double to_double(const ArrangementKernel::FT& value) {
    return CGAL::to_double(CGAL::exact(value));
}

class Overlay {
public:
    /// Edges of a kind form closed contours.
    Overlay(const Edges& given_edges, const Edges& found_edges);
    Overlay(const Overlay&) = delete;
    Overlay& operator=(const Overlay&) = delete;

    Arrangement& arrangement() { return arrangement_; }
    /// Winding number on the left of the half-edge minus that on its right.
    std::int64_t step(Halfedge halfedge, Kind kind) const;
    bool runs_along(Halfedge halfedge, Kind kind) const;
    /// The contours around the faces that are filled. Throws std::logic_error if a corner lies off the grid.
    regions::Region region(const std::function<bool(const FaceData&)>& filled);

private:
    struct Edge {
        Kind kind;
        bool left_to_right;
    };
    void add(const Edges& edges, Kind kind, std::vector<Traits::Curve_2>& curves);
    void count_windings();
    void number_solids(const std::function<bool(const FaceData&)>& filled);

    std::vector<Edge> edges_;
    Arrangement arrangement_;
};

/// Calls take(half-edge) for all half-edges that have the face on their left.
template <class Take>
void around(Face face, const Take& take) {
    const auto circle = [&](auto first) {
        auto at = first;
        do {
            take(Halfedge(at));
        } while (++at != first);
    };
    for (auto ccb = face->outer_ccbs_begin(); ccb != face->outer_ccbs_end(); ++ccb) {
        circle(*ccb);
    }
    for (auto ccb = face->inner_ccbs_begin(); ccb != face->inner_ccbs_end(); ++ccb) {
        circle(*ccb);
    }
}

}  // namespace exact
