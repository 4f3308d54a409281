// Prints what CGAL makes of a mesh file: answer_cgal FILE. Of a mesh: how many triangles, and nine coordinates for each.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>

#include <array>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

int main(int count, char** words) {
    if (count != 2) {
        return 2;
    }
    std::vector<CGAL::Exact_predicates_inexact_constructions_kernel::Point_3> points;
    std::vector<std::vector<std::size_t>> polygons;
    bool read = false;
    try {
        read = CGAL::IO::read_polygon_soup(words[1], points, polygons, CGAL::parameters::verbose(false));
    } catch (const std::exception&) {
    }
    std::vector<std::array<std::size_t, 3>> triangles;
    for (const std::vector<std::size_t>& polygon : polygons) {
        for (const std::size_t corner : polygon) {
            read = read && corner < points.size();
        }
        for (std::size_t i = 2; i < polygon.size(); ++i) {
            triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
        }
    }
    std::printf("%s\n", read ? (std::to_string(triangles.size()) + " triangles").c_str() : "refused");
    for (std::size_t i = 0; read && i < 3 * triangles.size(); ++i) {
        const auto& point = points[triangles[i / 3][i % 3]];
        std::printf("%.17g %.17g %.17g%c", point.x(), point.y(), point.z(), i % 3 == 2 ? '\n' : ' ');
    }
    return 0;
}
