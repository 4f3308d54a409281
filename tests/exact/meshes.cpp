#include "exact/meshes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

namespace exact {

using shapes::append;
using shapes::Xyz;

namespace {

using Random = std::mt19937_64;

double integer_to(Random& random, std::uint64_t range) {
    return static_cast<double>(random() % (range + 1));
}

double fraction(Random& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace

Soup hull(std::uint64_t seed, int points, std::uint64_t range) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
    Random random(seed);
    const auto coordinate = [&] { return integer_to(random, 2 * range) - static_cast<double>(range); };
    std::vector<Kernel::Point_3> cloud{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < points; ++i) {
        const double x = coordinate();
        const double y = coordinate();
        cloud.emplace_back(x, y, coordinate());
    }
    Mesh mesh;
    CGAL::convex_hull_3(cloud.begin(), cloud.end(), mesh);
    Soup soup;
    for (const Mesh::Face_index face : mesh.faces()) {
        for (const Mesh::Vertex_index vertex : mesh.vertices_around_face(mesh.halfedge(face))) {
            const Kernel::Point_3& p = mesh.point(vertex);
            soup.insert(soup.end(), {p.x(), p.y(), p.z()});
        }
    }
    return soup;
}

Soup crossing_hulls(std::uint64_t seed, int count) {
    Random random(seed);
    Soup soup;
    for (int i = 0; i < count; ++i) {
        const double size = (2 + 8 * fraction(random)) * 0x1p-20;
        const Soup one = shapes::scaled(hull(random(), 12, 1U << 20), {size, size, size});
        const double x = 20 * fraction(random);
        const double y = 20 * fraction(random);
        const Soup placed = shapes::moved(one, {x, y, 4 * fraction(random)});
        append(soup, random() % 3 == 0 ? shapes::flipped(placed) : placed);
    }
    return soup;
}

Soup shells(std::uint64_t seed, int count) {
    Random random(seed);
    Soup soup;
    for (int cell = 0; cell < count * count * count; ++cell) {
        const auto [x, y, z] = Xyz{4.0 * (cell % count), 4.0 * (cell / count % count), 4.0 * (cell / count / count)};
        const std::uint64_t depth = 1 + random() % 4;
        const bool is_box = random() % 2 == 0;
        double reach = 0.5 + fraction(random);
        for (std::uint64_t level = 0; level < depth; ++level, reach *= 0.5) {
            const Soup shell = is_box ? shapes::box({x - reach, y - reach, z - reach}, {x + reach, y + reach, z + reach})
                                      : shapes::octasphere({x, y, z}, reach, static_cast<int>(random() % 2));
            append(soup, level % 2 == 0 ? shell : shapes::flipped(shell));
        }
    }
    return soup;
}

Soup needles(std::uint64_t seed, int count, double width_mm) {
    constexpr double half_length_mm = 50;
    Random random(seed);
    Soup soup;
    for (int needle = 0; needle < count; ++needle) {
        Soup leaning = shapes::scaled(shapes::octasphere({0, 0, 0}, 1, 0), {width_mm / 2, width_mm / 2, half_length_mm});
        const double lean_x = 3 * fraction(random) - 1.5;
        const double lean_y = 3 * fraction(random) - 1.5;
        for (std::size_t i = 0; i < leaning.size(); i += 3) {
            leaning[i] += lean_x * leaning[i + 2];
            leaning[i + 1] += lean_y * leaning[i + 2];
        }
        append(soup, shapes::moved(leaning, {200.0 * (needle % 4), 200.0 * (needle / 4), integer_to(random, 10)}));
    }
    return soup;
}

Soup cells(std::uint64_t seed, int size) {
    Random random(seed);
    std::set<std::array<int, 3>> full;
    for (int cell = 0; cell < size * size * size; ++cell) {
        if (random() % 2 == 0) {
            full.insert({cell % size, cell / size % size, cell / size / size});
        }
    }
    constexpr int sides[6][3] = {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};  // as a box has them
    Soup soup;
    for (const auto& [x, y, z] : full) {
        const Soup cell = shapes::box({1.0 * x, 1.0 * y, 1.0 * z}, {x + 1.0, y + 1.0, z + 1.0});
        for (std::size_t side = 0; side < 6; ++side) {
            if (full.count({x + sides[side][0], y + sides[side][1], z + sides[side][2]}) == 0) {
                append(soup, shapes::only(cell, 2 * side, 2));
            }
        }
    }
    return soup;
}

lamella::SliceOptions through_vertices(const Soup& soup, double grid_mm, std::uint64_t seed, std::size_t most) {
    Random random(seed);
    std::vector<double> heights;
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        heights.push_back(soup[i]);
    }
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    const double low = heights.front();
    const double high = heights.back();
    std::shuffle(heights.begin(), heights.end(), random);
    heights.resize(std::min(heights.size(), most));
    for (std::size_t between = heights.size(); between > 0; --between) {
        heights.push_back(low + (high - low) * fraction(random));
    }
    std::sort(heights.begin(), heights.end());
    // Planes must still differ after rounding.
    const auto on_grid = [&](double mm) { return std::nearbyint(mm / (2 * grid_mm)); };
    const auto equal = [&](double a, double b) { return on_grid(a) == on_grid(b); };
    heights.erase(std::unique(heights.begin(), heights.end(), equal), heights.end());
    lamella::SliceOptions options;
    options.heights_mm = heights;
    options.planes.side = seed % 2 == 0 ? lamella::PlaneSide::below : lamella::PlaneSide::above;
    options.frame.grid_mm = grid_mm;
    return options;
}

}  // namespace exact
