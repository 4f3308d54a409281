#include "exact/arrangement.hpp"

#include <algorithm>

namespace exact {

Edges edges_of(const regions::Polygons& polygons) {
    Edges edges;
    for (const regions::Polygon& polygon : polygons) {
        rings::each_edge(polygon, [&](regions::Point from, regions::Point to) {
            edges.emplace_back(Corner(from.x, from.y), Corner(to.x, to.y));
        });
    }
    return edges;
}

Overlay::Overlay(const Edges& given_edges, const Edges& found_edges) {
    std::vector<Traits::Curve_2> curves;
    add(given_edges, given, curves);
    add(found_edges, found, curves);
    CGAL::insert(arrangement_, curves.begin(), curves.end());
    count_windings();
}

void Overlay::add(const Edges& edges, Kind kind, std::vector<Traits::Curve_2>& curves) {
    for (const auto& [from, to] : edges) {
        if (const CGAL::Comparison_result order = CGAL::compare_xy(from, to); order != CGAL::EQUAL) {
            const bool left_to_right = order == CGAL::SMALLER;
            const CGAL::Arr_segment_2<ArrangementKernel> rising(left_to_right ? from : to, left_to_right ? to : from);
            curves.emplace_back(rising, Along{static_cast<std::uint32_t>(edges_.size())});
            edges_.push_back({kind, left_to_right});
        }
    }
}

std::int64_t Overlay::step(Halfedge halfedge, Kind kind) const {
    const bool left_to_right = halfedge->direction() == CGAL::ARR_LEFT_TO_RIGHT;
    std::int64_t sum = 0;
    for (const std::uint32_t number : halfedge->curve().data()) {
        const Edge& edge = edges_[number];
        sum += edge.kind != kind ? 0 : (edge.left_to_right == left_to_right ? 1 : -1);
    }
    return sum;
}

bool Overlay::runs_along(Halfedge halfedge, Kind kind) const {
    const Along& along = halfedge->curve().data();
    return std::any_of(along.begin(), along.end(), [&](std::uint32_t number) { return edges_[number].kind == kind; });
}

void Overlay::count_windings() {
    std::deque<Face> open{arrangement_.unbounded_face()};
    open.front()->data().reached = true;
    for (; !open.empty(); open.pop_front()) {
        const Face face = open.front();
        around(face, [&](Halfedge halfedge) {
            const Face beyond = halfedge->twin()->face();
            FaceData data{true, {}};
            for (const Kind kind : {given, found}) {
                data.winding[kind] = face->data().winding[kind] - step(halfedge, kind);
            }
            if (!beyond->data().reached) {
                beyond->data() = data;
                open.push_back(beyond);
            } else if (beyond->data().winding[given] != data.winding[given] ||
                       beyond->data().winding[found] != data.winding[found]) {
                throw std::logic_error("the winding number of a face depends on the way to it");
            }
        });
    }
}

}  // namespace exact
