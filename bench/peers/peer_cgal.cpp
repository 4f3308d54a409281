// CGAL: Polygon_mesh_slicer on a Surface_mesh, one plane a call. All calls share one tree of the mesh's edges.
// Predicates are exact; points are rounded. Planes are declared parallel to two axes, which CGAL slices by a faster
// method.
#include <array>
#include <vector>

#include <CGAL/AABB_halfedge_graph_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_slicer.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/version.h>

#include "peer.hpp"

namespace {

using namespace lamella::peers;  // NOLINT(google-build-using-namespace)

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_halfedge_graph_segment_primitive<SurfaceMesh>>>;
using Slicer = CGAL::Polygon_mesh_slicer<SurfaceMesh, Kernel>;
using Polylines = std::vector<std::vector<Kernel::Point_3>>;

using Triangle = std::array<std::size_t, 3>;

/// Orients only a soup that is not a mesh as it stands, as CGAL's documentation advises. Orienting also splits faces at
/// edges that have more than two.
SurfaceMesh mesh_of(const Problem& problem) {
    namespace pmp = CGAL::Polygon_mesh_processing;
    std::vector<Kernel::Point_3> points;
    points.reserve(3 * problem.triangles());
    for (std::size_t i = 0; i < problem.soup.size(); i += 3) {
        points.emplace_back(problem.soup[i], problem.soup[i + 1], problem.soup[i + 2]);
    }
    std::vector<Triangle> triangles(problem.triangles());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        triangles[t] = {3 * t, 3 * t + 1, 3 * t + 2};
    }
    pmp::merge_duplicate_points_in_polygon_soup(points, triangles);
    std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    if (!pmp::is_polygon_soup_a_polygon_mesh(triangles)) {
        pmp::orient_polygon_soup(points, triangles);
    }
    SurfaceMesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, triangles, mesh);
    return mesh;
}

Seconds run(const Problem& problem, Counts& counts) {
    const auto start = lamella::Clock::now();
    const SurfaceMesh mesh = mesh_of(problem);
    Tree tree(edges(mesh).first, edges(mesh).second, mesh);
    tree.build();
    const Slicer slicer(mesh, tree);
    const double build_s = seconds_since(start);
    std::vector<Polylines> contours(problem.planes_mm.size());
    const lamella::Parallel parallel({.threads = problem.threads});
    parallel.run(contours.size(), [&](std::size_t plane, int) {
        slicer(Kernel::Plane_3(0, 0, 1, -problem.planes_mm[plane]), std::back_inserter(contours[plane]));
    });
    const double all_s = seconds_since(start);
    counts.reserve(contours.size());
    for (const Polylines& polylines : contours) {
        counts.push_back(polylines.size());
    }
    return {build_s, all_s - build_s};
}

}  // namespace

int main(int count, char** words) {
    return run_peer(run, count, words);
}
