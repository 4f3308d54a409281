// Prints what CGAL makes of a mesh file: answer_cgal FILE
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/IO/polygon_soup_io.h>

#include <cstdio>
#include <exception>
#include <vector>

#include "measure.hpp"

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
    sloppy::Measure measure;
    for (const std::vector<std::size_t>& polygon : polygons) {
        for (std::size_t i = 2; read && i < polygon.size(); ++i) {
            std::array<sloppy::Point, 3> corners;
            const std::array<std::size_t, 3> of = {polygon[0], polygon[i - 1], polygon[i]};
            for (std::size_t c = 0; c < 3; ++c) {
                if (of[c] >= points.size()) {
                    read = false;
                    break;
                }
                corners[c] = {points[of[c]].x(), points[of[c]].y(), points[of[c]].z()};
            }
            if (read) {
                measure.add(corners[0], corners[1], corners[2]);
            }
        }
    }
    std::printf("%s\n", read ? measure.words().c_str() : "refused");
    return 0;
}
