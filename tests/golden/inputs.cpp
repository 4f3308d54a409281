#include "golden/inputs.hpp"

#include <cstddef>
#include <functional>
#include <numeric>

#include "engine/slicing.hpp"
#include "slicing/tuning.hpp"

namespace golden {

namespace {

using lamella::models::Random;
using namespace shapes;
using shapes::append;

using Cell = std::array<int, 3>;

void append(Soup& soup, const Xyz& a, const Xyz& b, const Xyz& c) {
    append(soup, shapes::triangle(a, b, c));
}

std::uint64_t mixed(std::uint64_t seed, const Cell& cell) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + 1000); };
    return Random(seed ^ part(cell[0]) << 40 ^ part(cell[1]) << 20 ^ part(cell[2])).next();
}

/// A ball of cells of 1 mm with a lump at its side; one cell in eleven is missing, which makes cavities, and cells that
/// meet at an edge or a corner alone.
struct Voxels {
    int side;
    std::uint64_t seed;

    bool filled(const Cell& cell) const {
        for (const int i : cell) {
            if (i < 0 || i >= side) {
                return false;
            }
        }
        const auto near = [&](const Cell& centre, int radius) {
            int sum = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const int d = 2 * cell[axis] + 1 - centre[axis];
                sum += d * d;
            }
            return sum <= 4 * radius * radius;
        };
        return (near({side, side, side}, side / 3) || near({3 * side / 2, side, 3 * side / 2}, side / 4)) &&
               mixed(seed, cell) % 11 != 0;
    }

    /// A corner of cells, moved by less than a third of a cell, in steps of 1/64 mm: vertices are still shared.
    Xyz corner(const Cell& node) const {
        Xyz p{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto jitter = static_cast<int>(mixed(seed + 1 + axis, node) % 41) - 20;
            p[axis] = (64 * node[axis] + jitter) / 64.0;
        }
        return p;
    }

    /// The face of `cell` towards `axis`, upwards or downwards, seen counter-clockwise from outside.
    void add_face(Soup& soup, const Cell& cell, std::size_t axis, bool up) const {
        std::array<Xyz, 4> p;
        for (std::size_t i = 0; i < 4; ++i) {
            Cell node = cell;
            node[axis] += up ? 1 : 0;
            node[(axis + 1) % 3] += i == 1 || i == 2 ? 1 : 0;
            node[(axis + 2) % 3] += i >= 2 ? 1 : 0;
            p[up ? i : 3 - i] = corner(node);
        }
        const std::size_t first = mixed(seed + 9, cell) & 1;  // which diagonal
        append(soup, quad(p[first], p[first + 1], p[first + 2], p[(first + 3) % 4]));
    }

    Soup surface() const {
        Soup soup;
        for (int i = 0; i < side * side * side; ++i) {
            const Cell cell{i % side, i / side % side, i / side / side};
            if (!filled(cell)) {
                continue;
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (const bool up : {false, true}) {
                    Cell neighbour = cell;
                    neighbour[axis] += up ? 1 : -1;
                    if (!filled(neighbour)) {
                        add_face(soup, cell, axis, up);
                    }
                }
            }
        }
        return soup;
    }
};

Soup voxel_body(std::uint64_t seed = 1, int side = 28) {
    return Voxels{side, seed}.surface();
}

/// Calls change(triangle as nine numbers) for one triangle in `every`, by hash.
template <class Change>
Soup each_so_manieth(Soup soup, std::uint64_t every, Change change) {
    Random random(every);
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        if (random.next() % every == 0) {
            change(soup.begin() + static_cast<std::ptrdiff_t>(t));
        }
    }
    return soup;
}

Soup torn(const Soup& soup, std::uint64_t every) {
    Random random(every);
    Soup left;
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        if (random.next() % every != 0) {
            append(left, shapes::only(soup, t, 1));
        }
    }
    return left;
}

/// Corners of some triangles leave their neighbours by up to 3/64 mm.
Soup cracked(const Soup& soup) {
    Random random(5);
    return each_so_manieth(soup, 13, [&](auto triangle) {
        for (std::ptrdiff_t i = 0; i < 9; ++i) {
            triangle[i] += between(random, -3, 3) / 64.0;
        }
    });
}

Soup of_mixed_orientations(const Soup& soup) {
    return each_so_manieth(soup, 9, [](auto t) { std::swap_ranges(t + 3, t + 6, t + 6); });
}

/// Collapsed triangles, triangles on a line, copies, and copies turned over.
Soup with_degenerate_faces(const Soup& soup) {
    Soup all = soup;
    for (std::size_t t = 0; t + 9 <= soup.size(); t += 9 * 7) {
        const auto corner = [&](std::size_t i) { return Xyz{soup[t + 3 * i], soup[t + 3 * i + 1], soup[t + 3 * i + 2]}; };
        const Xyz a = corner(0);
        const Xyz b = corner(1);
        const Xyz c = corner(2);
        append(all, a, a, b);
        append(all, a, b, {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
        append(all, a, b, c);
        if (t % 2 == 0) {
            append(all, a, c, b);
        }
    }
    return all;
}

/// Boxes with corners on whole millimetres, overlapping, touching and within each other; one in four is inverted.
Soup random_boxes(std::uint64_t seed, int count, int range) {
    Random random(seed);
    Soup soup;
    for (int i = 0; i < count; ++i) {
        Xyz low{};
        Xyz high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const int from = between(random, 0, range);
            low[axis] = from;
            high[axis] = from + between(random, 1, range / 3);
        }
        append(soup, random.next() % 4 == 0 ? flipped(box(low, high)) : box(low, high));
    }
    return soup;
}

/// Small tetrahedra, outward or inward as it happens, or triangles, all over a larger cube. Their corners lie on a lattice
/// of `steps` to a millimetre: on a coarse one they share vertices and edges, many faces an edge.
Soup on_lattice(std::uint64_t seed, int count, int spread, int range, int steps, bool tetrahedra) {
    Random random(seed);
    Soup soup;
    for (int i = 0; i < count; ++i) {
        Cell from{};
        std::generate(from.begin(), from.end(), [&] { return between(random, 0, spread); });
        std::array<Xyz, 4> p{};
        for (std::size_t number = 0; number < (tetrahedra ? 12 : 9); ++number) {
            p[number / 3][number % 3] = from[number % 3] + between(random, 0, steps * range) / double(steps);
        }
        append(soup, tetrahedra ? shapes::tetrahedron(p[0], p[1], p[2], p[3]) : shapes::triangle(p[0], p[1], p[2]));
    }
    return soup;
}

/// A prism over an outline that may cross itself, each side leaning by `lean` over the height; caps are fans.
Soup prism_over(const std::vector<std::array<int, 2>>& outline, int height, int lean) {
    const auto at = [&](std::size_t i, bool top) {
        const auto& p = outline[i % outline.size()];
        return Xyz{double(p[0] + (top ? lean : 0)), double(p[1]), double(top ? height : 0)};
    };
    Soup soup;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        append(soup, quad(at(i, false), at(i + 1, false), at(i + 1, true), at(i, true)));
        if (i > 0 && i + 1 < outline.size()) {
            append(soup, at(0, false), at(i + 1, false), at(i, false));
            append(soup, at(0, true), at(i, true), at(i + 1, true));
        }
    }
    return soup;
}

/// A pentagram, a figure of eight, and an outline that runs round twice.
Soup self_crossing_prisms() {
    return joined({prism_over({{0, 9}, {-6, -8}, {9, 3}, {-9, 3}, {6, -8}}, 8, 3),
                   moved(prism_over({{0, 0}, {10, 8}, {10, 0}, {0, 9}}, 8, -2), {14, 0, 0}),
                   moved(prism_over({{0, 0}, {9, 1}, {8, 9}, {1, 8}, {2, 2}, {7, 3}, {6, 7}, {-1, 6}}, 8, 1), {0, 14, 0})});
}

Soup nested_boxes() {
    Soup soup;
    for (int i = 0; i < 12; ++i) {  // orientations: + - + + - - + - + + - -
        const Soup one = box({double(i), double(i), double(i)}, {40.0 - i, 41.0 - i, 42.0 - i});
        append(soup, i % 6 == 1 || i % 6 >= 4 ? flipped(one) : one);
    }
    return soup;
}

/// Every other cell of a cube: edges of four faces everywhere inside.
Soup checkerboard() {
    Soup soup;
    for (int i = 0; i < 512; ++i) {
        const double x = i % 8;
        const double y = i / 8 % 8;
        const double z = i / 64;
        if ((i % 8 + i / 8 % 8 + i / 64) % 2 == 0) {
            append(soup, box({x, y, z}, {x + 1, y + 1, z + 1}));
        }
    }
    return soup;
}

/// Bodies that run through each other, through themselves and, turned over, within each other.
Soup crossing_bodies() {
    const Soup body = voxel_body(2, 14);
    return joined({body, moved(body, {2.5, 1.25, 3}), flipped(moved(body, {1, 3.5, -2})),
                   moved(flipped(voxel_body(3, 9)), {3, 3, 3})});
}

/// The walls of a comb: one contour of 8 segments a tooth.
Soup comb(int teeth) {
    std::vector<std::array<double, 2>> outline;
    for (int i = 0; i < teeth; ++i) {
        outline.insert(outline.end(), {{4.0 * i, 0}, {4.0 * i + 2, 0}});
    }
    for (int i = teeth; i-- > 0;) {
        outline.insert(outline.end(), {{4.0 * i + 2, 9.0 + i % 5}, {4.0 * i, 7.0 - i % 3}});
    }
    return shapes::scaled(shapes::walls(outline), {1 / 64.0, 1 / 64.0, 0.1});
}

/// The same triangles, each far in memory from what was its neighbour.
Soup strewn(const Soup& soup) {
    const std::uint64_t count = soup.size() / 9;
    std::uint64_t stride = count / 3 * 2 + 1;
    while (std::gcd(stride, count) != 1) {
        ++stride;
    }
    Soup strewn;
    strewn.reserve(soup.size());
    for (std::uint64_t t = 0; t < count; ++t) {
        const auto from = soup.begin() + static_cast<std::ptrdiff_t>(t * stride % count * 9);
        strewn.insert(strewn.end(), from, from + 9);
    }
    return strewn;
}

/// Combs, and 9,000 boxes with a cavity each, some of which touch: together 2^18 and more segments in a plane.
Soup wide_boxes() {
    Soup soup = joined({moved(comb(12'000), {0, -4, 0}), moved(comb(4'800), {0, -8, 0})});
    for (int i = 0; i < 9'000; ++i) {
        const double x = i % 130 * 2.0;
        const double y = i / 130 * 2.0;
        // A box that touches the next one shares no edge with it: such a plane is not treated as wide.
        const bool touches = i % 17 == 0;
        append(soup, box({x, touches ? y - 0.25 : y, 0}, {x + (touches ? 2 : 1.75), y + (touches ? 1.625 : 1.5), 1}));
        append(soup, flipped(box({x + 0.25, y + 0.25, 0.125}, {x + 1.25, y + 1.25, 0.875})));
    }
    return strewn(soup);
}

const std::map<std::string, std::function<Soup()>>& makers() {
    static const std::map<std::string, std::function<Soup()>> all = {
        {"voxel body", [] { return voxel_body(); }},
        {"torn body", [] { return torn(voxel_body(), 60); }},
        {"cracked body", [] { return cracked(voxel_body()); }},
        {"body of mixed senses", [] { return of_mixed_orientations(voxel_body()); }},
        {"body with degenerate faces", [] { return with_degenerate_faces(voxel_body(4, 14)); }},
        {"crossing bodies", [] { return crossing_bodies(); }},
        {"overlapping boxes", [] { return random_boxes(7, 120, 24); }},
        {"nested boxes", [] { return nested_boxes(); }},
        {"checkerboard", [] { return checkerboard(); }},
        {"tetrahedra", [] { return on_lattice(11, 400, 24, 6, 4, true); }},
        {"crowded tetrahedra", [] { return on_lattice(12, 60, 1, 7, 4, true); }},
        {"lattice triangles", [] { return on_lattice(13, 1500, 16, 3, 1, false); }},
        {"self-crossing prisms", [] { return self_crossing_prisms(); }},
        {"wide comb", [] { return comb(33'000); }},
        {"wide boxes", [] { return wide_boxes(); }},
    };
    return all;
}

}  // namespace

Soup mesh(const std::string& name) {
    return makers().at(name)();
}

std::vector<std::string> mesh_names() {
    std::vector<std::string> names;
    for (const auto& [name, make] : makers()) {
        names.push_back(name);
    }
    return names;
}

}  // namespace golden

namespace shape_cases {

std::map<std::string, shapes::Soup> meshes() {
    const shapes::Soup ball = shapes::octasphere({0, 0, 0}, 10, 4);
    shapes::Soup torn = ball;
    torn.resize(torn.size() - 9 * std::size_t{40});
    return {{"ball", ball},
            {"torn ball", torn},
            {"crossing balls", shapes::joined({ball, shapes::moved(ball, {3, 4, 5}), shapes::flipped(ball)})},
            {"tetrahedra", shapes::random_tetrahedra(11, 60, 9)},
            {"tangle", shapes::joined({shapes::random_soup(5, 200, 8), shapes::random_tetrahedra(6, 20, 8)})},
            {"bone", generated(lamella::models::Shape::bone, 30'000)},
            {"gyroid", generated(lamella::models::Shape::gyroid, 30'000)},
            {"torus", generated(lamella::models::Shape::torus, 5'000)},
            {"prism", generated(lamella::models::Shape::prism, 2'000)}};
}

std::map<std::string, lamella::SliceOptions> plans(const shapes::Soup& mesh) {
    std::map<std::string, lamella::SliceOptions> plans;
    plans["uniform"] = uniform(0.25);
    plans["coarse grid"] = uniform(0.25, 0x1p-8);
    const lamella::Tuning random{.random_heights = lamella::RandomHeights{0.1, 0.4, 1}};
    plans["random"].heights_mm = sliced(mesh, {}, {}, random).info.options.heights_mm;
    plans["explicit"].heights_mm = {{-8.5, -3, -1, 0, 0.5, 1, 2, 3, 3.0625, 4, 7, 9, 15}};
    plans["explicit"].planes.side = lamella::PlaneSide::above;
    return plans;
}

}  // namespace shape_cases
