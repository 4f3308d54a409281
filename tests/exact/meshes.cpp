#include "exact/meshes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

namespace exact {

using shapes::append;
using shapes::quad;
using shapes::Xyz;

namespace {

using Random = std::mt19937_64;

double integer_to(Random& random, std::uint64_t range) {
    return static_cast<double>(random() % (range + 1));
}

double fraction(Random& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

void add(Soup& soup, Xyz a, Xyz b, Xyz c) {
    append(soup, shapes::triangle(a, b, c));
}

Xyz sum(Xyz a, Xyz b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

Xyz times(Xyz a, double factor) {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

Xyz cross(Xyz a, Xyz b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Xyz direction(Xyz a) {
    return times(a, 1 / std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]));
}

Xyz random_direction(Random& random) {
    for (;;) {
        const Xyz p{2 * fraction(random) - 1, 2 * fraction(random) - 1, 2 * fraction(random) - 1};
        const double square = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
        if (square > 0.01 && square < 1) {
            return direction(p);
        }
    }
}

void add_cell_side(Soup& soup, const int (&place)[3], std::size_t axis, bool upper) {
    Xyz corner{static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])};
    corner[axis] += upper ? 1 : 0;
    Xyz next = corner;
    next[(axis + 1) % 3] += 1;
    Xyz last = corner;
    last[(axis + 2) % 3] += 1;
    Xyz across = next;
    across[(axis + 2) % 3] += 1;
    append(soup, quad(corner, upper ? next : last, across, upper ? last : next));
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
        const Xyz centre{4.0 * (cell % count), 4.0 * (cell / count % count), 4.0 * (cell / count / count)};
        const std::uint64_t depth = 1 + random() % 4;
        const bool is_box = random() % 2 == 0;
        double reach = 0.5 + fraction(random);
        for (std::uint64_t level = 0; level < depth; ++level, reach *= 0.5) {
            const Xyz corner{reach, reach, reach};
            const Soup shell = is_box ? shapes::box(sum(centre, times(corner, -1)), sum(centre, corner))
                                      : shapes::octasphere(centre, reach, static_cast<int>(random() % 2));
            append(soup, level % 2 == 0 ? shell : shapes::flipped(shell));
        }
    }
    return soup;
}

Soup needles(std::uint64_t seed, int count, double width_mm) {
    constexpr double half_length_mm = 50;
    constexpr int sides = 5;
    Random random(seed);
    Soup soup;
    for (int needle = 0; needle < count; ++needle) {
        const Xyz along = random_direction(random);
        const Xyz u = direction(cross(along, random_direction(random)));
        const Xyz v = cross(along, u);
        const Xyz centre{4 * half_length_mm * (needle % 4), 4 * half_length_mm * (needle / 4), integer_to(random, 10)};
        const auto rim = [&](int side) {
            const double turn = 2 * std::numbers::pi * side / sides;
            return sum(centre, sum(times(u, width_mm / 2 * std::cos(turn)), times(v, width_mm / 2 * std::sin(turn))));
        };
        const Xyz head = sum(centre, times(along, half_length_mm));
        const Xyz foot = sum(centre, times(along, -half_length_mm));
        for (int side = 0; side < sides; ++side) {
            const Xyz a = rim(side);
            const Xyz b = rim((side + 1) % sides);
            add(soup, a, b, head);
            add(soup, b, a, foot);
        }
    }
    return soup;
}

Soup cells(std::uint64_t seed, int size) {
    Random random(seed);
    const int wide = size + 2;  // with empty cells all around
    std::vector<char> full(static_cast<std::size_t>(wide * wide * wide), 0);
    const auto at = [wide](int x, int y, int z) { return static_cast<std::size_t>((z * wide + y) * wide + x); };
    for (int cell = 0; cell < size * size * size; ++cell) {
        full[at(1 + cell % size, 1 + cell / size % size, 1 + cell / size / size)] = static_cast<char>(random() % 2);
    }
    Soup soup;
    for (std::size_t cell = 0; cell < full.size(); ++cell) {
        const int place[] = {static_cast<int>(cell) % wide, static_cast<int>(cell) / wide % wide,
                             static_cast<int>(cell) / wide / wide};
        for (std::size_t axis = 0; axis < 3 && full[cell] != 0; ++axis) {
            for (const int step : {-1, 1}) {
                int beside[] = {place[0], place[1], place[2]};
                beside[axis] += step;
                if (full[at(beside[0], beside[1], beside[2])] == 0) {
                    add_cell_side(soup, place, axis, step > 0);
                }
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
