#include "exact/second_opinion.hpp"

#include <algorithm>
#include <map>

#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_slicer.h>
#include <CGAL/Surface_mesh.h>

#include "exact/exact_slice.hpp"

namespace exact {

namespace {

using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Ring = std::vector<Point2>;

/// The soup as a mesh; empty if the triangles do not form a manifold.
Mesh mesh_of(std::span<const oracle::Triangle> triangles) {
    std::map<lamella::GridVertex, std::size_t> known;
    std::vector<Kernel::Point_3> points;
    std::vector<std::vector<std::size_t>> faces;
    for (const oracle::Triangle& t : triangles) {
        std::vector<std::size_t>& face = faces.emplace_back();
        for (const lamella::GridVertex v : t) {
            const auto [place, fresh] = known.try_emplace(v, points.size());
            if (fresh) {
                points.emplace_back(v.x, v.y, v.z);
            }
            face.push_back(place->second);
        }
    }
    Mesh mesh;
    if (CGAL::Polygon_mesh_processing::is_polygon_soup_a_polygon_mesh(faces)) {
        CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, faces, mesh);
    }
    return mesh;
}

/// Starts at the smallest point and continues towards its smaller neighbour, so all starts and both directions give the
/// same.
Ring normal_form(Ring ring) {
    const Kernel::Less_xy_2 less;
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end(), less), ring.end());
    if (ring.size() > 2 && less(ring.back(), ring[1])) {
        std::reverse(ring.begin() + 1, ring.end());
    }
    return ring;
}

std::vector<Ring> in_order(std::vector<Ring> rings) {
    const Kernel::Less_xy_2 less;
    std::sort(rings.begin(), rings.end(), [&](const Ring& a, const Ring& b) {
        return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), less);
    });
    return rings;
}

}  // namespace

std::string second_opinion(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles) {
    const Mesh mesh = mesh_of(triangles);
    if (mesh.is_empty() || !CGAL::is_closed(mesh)) {
        return "the triangles form no closed manifold";
    }
    const CGAL::Polygon_mesh_slicer<Mesh, Kernel> slicer(mesh);
    for (const lamella::Layer& layer : result.layers) {
        std::vector<std::vector<Kernel::Point_3>> polylines;
        slicer(Kernel::Plane_3(0, 0, 1, -layer.plane.z()), std::back_inserter(polylines));
        std::vector<Ring> theirs;
        for (const std::vector<Kernel::Point_3>& polyline : polylines) {
            Ring ring;
            std::transform(polyline.begin(), polyline.end() - 1, std::back_inserter(ring),
                           [](const Kernel::Point_3& p) { return Point2(p.x(), p.y()); });
            theirs.push_back(normal_form(std::move(ring)));
        }
        std::vector<Ring> ours;
        for (Chain& chain : chains_at(triangles, layer.plane.z())) {
            ours.push_back(normal_form(std::move(chain.points)));
        }
        if (in_order(ours) != in_order(theirs)) {
            return std::string("plane ").append(std::to_string(layer.plane.z())) + ": " + std::to_string(ours.size()) +
                   " exact contours, CGAL's slicer has " + std::to_string(theirs.size()) + " or other points";
        }
    }
    return {};
}

}  // namespace exact
