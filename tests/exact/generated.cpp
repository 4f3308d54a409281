// Random closed meshes, sliced by the engine and in exact arithmetic. They are oriented outwards and do not intersect
// themselves unless stated. Most have vertices, edges and faces at equal heights, where planes are then placed. The long
// test runs the short one on thousands of seeds.
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

#include "engine/shapes.hpp"
#include "engine/slicing.hpp"
#include "exact/judge.hpp"
#include "models/models.hpp"

using lamella::models::Shape;
using shapes::append;
using shapes::Soup;
using shapes::Xyz;

namespace {

using Random = std::mt19937_64;

double integer_to(Random& random, std::uint64_t range) {
    return static_cast<double>(random() % (range + 1));
}

double fraction(Random& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// The hull of points with integer coordinates in [-range, range].
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

/// Hulls that intersect, with no common coordinates; about one in three is inside out.
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

/// count³ cells, each with up to four nested shells: solid, cavity, solid in the cavity, ...
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

/// Octahedra, 100 mm high and `width_mm` wide, that lean in random directions.
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

/// The surface of about half the cells of a cube: solids that touch along edges and at corners.
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

constexpr std::uint64_t few_seeds = 6;
constexpr std::uint64_t many_seeds = 200;
constexpr std::size_t few_planes = 6;
constexpr std::size_t many_planes = 40;

struct Kind {
    const char* name;
    double grid_mm;
    std::function<Soup(std::uint64_t seed, bool large)> make;
    bool contradictory = false;  ///< some facets' orientations contradict each other
};

constexpr double fine = lamella::default_grid_mm;

auto generator(Shape shape) {
    return [shape](std::uint64_t seed, bool large) { return generated(shape, large ? 20'000 : 2'000, seed); };
}

const std::vector<Kind>& kinds() {
    static const std::vector<Kind> all{
        {"hull on a coarse grid", coarse_unit_mm,
         [](std::uint64_t seed, bool large) { return hull(seed, large ? 400 : 60, 8 + seed % 50); }},
        {"hull at the edge of the grid", fine,
         [](std::uint64_t seed, bool large) {
             return shapes::moved(shapes::scaled(hull(seed, large ? 400 : 60, 1U << 20), {0x1p-14, 0x1p-14, 0x1p-14}),
                                  {-950, 950, 950});
         }},
        {"gyroid", fine, generator(Shape::gyroid)},
        {"bone", fine, generator(Shape::bone)},
        {"torus", fine, generator(Shape::torus)},
        {"shells", fine, [](std::uint64_t seed, bool large) { return shells(seed, large ? 7 : 4); }},
        {"needles", fine, [](std::uint64_t seed, bool large) { return needles(seed, large ? 20 : 8, 0.01); }},
        {"needles as thin as the grid", fine,
         [](std::uint64_t seed, bool large) { return needles(seed, large ? 20 : 8, 0x1p-17); }, true},
        {"crossing hulls, some inside out", fine,
         [](std::uint64_t seed, bool large) { return crossing_hulls(seed, large ? 30 : 8); }, true},
        {"cells that touch", coarse_unit_mm, [](std::uint64_t seed, bool large) { return cells(seed, large ? 12 : 4); }},
    };
    return all;
}

/// Number of contours whose role contradicts their facets. Skips contours so small that rounding their points can reverse
/// them, as just below the tip of a needle.
std::ptrdiff_t count_overruled(const lamella::SliceResult& result) {
    return std::count_if(result.contours.begin(), result.contours.end(), [&](const lamella::Contour& contour) {
        const auto length = 2 * static_cast<double>(rings::perimeter(result.points_of(contour)));
        return (contour.flags & lamella::orientation_overruled) != 0 && std::abs(contour.twice_area.to_double()) > length;
    });
}

/// Slices through heights of vertices and judges every layer. Returns the number of points.
std::size_t judge(const Kind& kind, std::uint64_t seed, bool large, std::size_t planes) {
    const Soup soup = kind.make(seed, large);
    INFO(kind.name << ", seed " << seed);
    const lamella::SliceResult result =
        sliced(soup, exact::through_vertices(soup, kind.grid_mm, seed, planes), {}, exact::form_of(seed));
    CHECK(result.info.open_contours == 0);
    CHECK((kind.contradictory || count_overruled(result) == 0));
    REQUIRE_THAT(exact::difference(result, oracle::quantise(soup, kind.grid_mm)), Catch::Equals(""));
    return result.points.size();
}

}  // namespace

TEST_CASE("contours of random closed meshes equal the exact ones", "[meshes]") {
    std::size_t points = 0;
    for (const Kind& kind : kinds()) {
        for (std::uint64_t seed = 0; seed < few_seeds; ++seed) {
            points += judge(kind, seed, false, few_planes);
        }
    }
    CHECK(points > 1'000 * few_seeds);
}

TEST_CASE("contours of thousands of random closed meshes equal the exact ones", "[meshes_long]") {
    for (const Kind& kind : kinds()) {
        for (std::uint64_t seed = 100; seed < 100 + many_seeds; ++seed) {
            const bool large = seed % 4 == 0;
            judge(kind, seed, large, large ? few_planes : many_planes);
        }
    }
}

TEST_CASE("the exact judge finds every kind of difference", "[meshes]") {
    const Soup soup = shells(5, 2);
    const std::vector<oracle::Triangle> triangles = oracle::quantise(soup, fine);
    const lamella::SliceOptions options = exact::through_vertices(soup, fine, 5, few_planes);
    const auto differs = [&](auto&& damage) {
        lamella::SliceResult result = sliced(soup, options, {}, exact::form_of(5));
        damage(result);
        return !exact::difference(result, triangles).empty();
    };
    CHECK_FALSE(differs([](lamella::SliceResult&) {}));
    CHECK(differs([](lamella::SliceResult& r) { r.points[3].x += 1; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[1].role = lamella::Role::flat; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[0].parent = 0; }));
    CHECK(differs([](lamella::SliceResult& r) { ++r.contours[0].segments; }));
    CHECK(differs([](lamella::SliceResult& r) { r.contours[0].twice_area.low ^= 2; }));
    CHECK(differs([](lamella::SliceResult& r) {
        const auto filled = [](const lamella::Layer& layer) { return layer.contour_count > 0; };
        --std::find_if(r.layers.begin(), r.layers.end(), filled)->contour_count;
    }));
}
