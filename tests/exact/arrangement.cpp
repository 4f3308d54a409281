#include "exact/arrangement.hpp"

#include <cmath>
#include <string>
#include <unordered_set>

namespace exact {

namespace {

std::int32_t grid_coordinate(const ArrangementKernel::FT& value) {
    const double nearest = std::nearbyint(to_double(value));
    if (value != nearest) {
        throw std::logic_error("a corner lies off the grid, near " + std::to_string(nearest));
    }
    return static_cast<std::int32_t>(nearest);
}

regions::Polygon corners_on_grid(const std::vector<Corner>& walk) {
    regions::Polygon corners;
    for (std::size_t i = 0; i < walk.size(); ++i) {
        const Corner& before = walk[(i + walk.size() - 1) % walk.size()];
        if (!CGAL::collinear(before, walk[i], walk[(i + 1) % walk.size()])) {
            corners.push_back({grid_coordinate(walk[i].x()), grid_coordinate(walk[i].y())});
        }
    }
    return corners;
}

}  // namespace

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
            FaceData data{true, {}, 0};
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

void Overlay::number_solids(const std::function<bool(const FaceData&)>& filled) {
    for (auto face = arrangement_.faces_begin(); face != arrangement_.faces_end(); ++face) {
        face->data().solid = 0;
    }
    std::size_t solids = 0;
    for (auto seed = arrangement_.faces_begin(); seed != arrangement_.faces_end(); ++seed) {
        if (seed->data().solid != 0 || !filled(seed->data())) {
            continue;
        }
        seed->data().solid = ++solids;
        for (std::deque<Face> open{seed}; !open.empty(); open.pop_front()) {
            around(open.front(), [&](Halfedge halfedge) {
                const Face beyond = halfedge->twin()->face();
                if (beyond->data().solid == 0 && filled(beyond->data())) {
                    beyond->data().solid = solids;
                    open.push_back(beyond);
                }
            });
        }
    }
}

regions::Region Overlay::region(const std::function<bool(const FaceData&)>& filled) {
    number_solids(filled);
    const auto bounds = [](Halfedge h) { return h->face()->data().solid != 0 && h->twin()->face()->data().solid == 0; };
    std::unordered_set<const void*> used;
    regions::Region region;
    for (auto first = arrangement_.halfedges_begin(); first != arrangement_.halfedges_end(); ++first) {
        std::vector<Corner> walk;
        for (Halfedge at = first; bounds(at) && used.insert(&*at).second;) {
            walk.push_back(at->source()->point());
            // The next one clockwise that bounds a solid: the faces between are all filled.
            for (at = at->next(); !bounds(at);) {
                at = at->twin()->next();
            }
        }
        if (!walk.empty()) {
            region.push_back({corners_on_grid(walk), false, -1});
        }
    }
    regions::find_parents(region);
    return regions::canonical(std::move(region));
}

}  // namespace exact
