#include "engine/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

namespace shapes {

namespace {

Xyz corner(const Soup& soup, std::size_t t, std::size_t i) {
    const std::size_t at = 9 * t + 3 * i;
    return {soup[at], soup[at + 1], soup[at + 2]};
}

void add(Soup& soup, Xyz a, Xyz b, Xyz c) {
    for (const Xyz& p : {a, b, c}) {
        soup.insert(soup.end(), p.begin(), p.end());
    }
}

/// std::uniform_int_distribution differs between libraries. The small bias of a remainder does not matter here.
double small_integer(std::mt19937_64& random, std::uint64_t range) {
    return static_cast<double>(random() % (range + 1));
}

Xyz onto_sphere(Xyz p, Xyz centre, double radius) {
    const double length = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (std::size_t i = 0; i < 3; ++i) {
        p[i] = centre[i] + radius * (p[i] / length);
    }
    return p;
}

Xyz middle(Xyz a, Xyz b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

Soup split_in_four(const Soup& soup) {
    Soup finer;
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        const Xyz a = corner(soup, t, 0);
        const Xyz b = corner(soup, t, 1);
        const Xyz c = corner(soup, t, 2);
        const Xyz ab = middle(a, b);
        const Xyz bc = middle(b, c);
        const Xyz ca = middle(c, a);
        add(finer, a, ab, ca);
        add(finer, ab, b, bc);
        add(finer, ca, bc, c);
        add(finer, ab, bc, ca);
    }
    return finer;
}

/// Corners of a nearly regular polygon, counter-clockwise, by the rational parameter of the circle, quarter by quarter.
std::vector<Xyz> polygon(int quarters, double radius) {
    std::vector<Xyz> corners;
    for (int quarter = 0; quarter < 4; ++quarter) {
        for (int i = 0; i < quarters; ++i) {
            const double t = static_cast<double>(i) / quarters;
            double x = radius * ((1 - t * t) / (1 + t * t));
            double y = radius * (2 * t / (1 + t * t));
            for (int turn = 0; turn < quarter; ++turn) {
                std::swap(x, y);
                x = -x;
            }
            corners.push_back({x, y, 0});
        }
    }
    return corners;
}

}  // namespace

Soup triangle(Xyz a, Xyz b, Xyz c) {
    Soup soup;
    add(soup, a, b, c);
    return soup;
}

Soup quad(Xyz a, Xyz b, Xyz c, Xyz d) {
    Soup soup;
    add(soup, a, b, c);
    add(soup, a, c, d);
    return soup;
}

Soup tetrahedron(Xyz a, Xyz b, Xyz c, Xyz d) {
    return joined({triangle(a, b, c), triangle(a, c, d), triangle(a, d, b), triangle(b, d, c)});
}

Soup wall(std::array<double, 2> from, std::array<double, 2> to) {
    return quad({from[0], from[1], 0}, {to[0], to[1], 0}, {to[0], to[1], 10}, {from[0], from[1], 10});
}

void append(Soup& soup, const Soup& more) {
    soup.insert(soup.end(), more.begin(), more.end());
}

Soup walls(const std::vector<std::array<double, 2>>& polygon) {
    Soup all;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        append(all, wall(polygon[i], polygon[(i + 1) % polygon.size()]));
    }
    return all;
}

Soup joined(std::initializer_list<Soup> parts) {
    Soup all;
    for (const Soup& part : parts) {
        append(all, part);
    }
    return all;
}

Soup flipped(Soup soup) {
    for (std::size_t t = 0; t < soup.size() / 9; ++t) {
        const auto first = soup.begin() + static_cast<std::ptrdiff_t>(9 * t);
        std::swap_ranges(first + 3, first + 6, first + 6);
    }
    return soup;
}

Soup moved(Soup soup, Xyz by) {
    for (std::size_t i = 0; i < soup.size(); ++i) {
        soup[i] += by[i % 3];
    }
    return soup;
}

Soup scaled(Soup soup, Xyz by) {
    for (std::size_t i = 0; i < soup.size(); ++i) {
        soup[i] *= by[i % 3];
    }
    return soup;
}

Soup without(Soup soup, std::size_t from, std::size_t count) {
    const auto at = soup.begin() + static_cast<std::ptrdiff_t>(9 * from);
    soup.erase(at, at + static_cast<std::ptrdiff_t>(9 * count));
    return soup;
}

Soup only(const Soup& soup, std::size_t from, std::size_t count) {
    const auto at = soup.begin() + static_cast<std::ptrdiff_t>(9 * from);
    return {at, at + static_cast<std::ptrdiff_t>(9 * count)};
}

Soup box(Xyz low, Xyz high) {
    const auto [x0, y0, z0] = low;
    const auto [x1, y1, z1] = high;
    return joined({quad({x0, y0, z0}, {x0, y1, z0}, {x1, y1, z0}, {x1, y0, z0}),
                   quad({x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1}),
                   quad({x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1}),
                   quad({x1, y0, z0}, {x1, y1, z0}, {x1, y1, z1}, {x1, y0, z1}),
                   quad({x1, y1, z0}, {x0, y1, z0}, {x0, y1, z1}, {x1, y1, z1}),
                   quad({x0, y1, z0}, {x0, y0, z0}, {x0, y0, z1}, {x0, y1, z1})});
}

Soup octasphere(Xyz centre, double radius, int level) {
    Soup soup;
    for (int octant = 0; octant < 8; ++octant) {
        const double sx = (octant & 1) != 0 ? -1 : 1;
        const double sy = (octant & 2) != 0 ? -1 : 1;
        const double sz = (octant & 4) != 0 ? -1 : 1;
        const Soup face = triangle({sx, 0, 0}, {0, sy, 0}, {0, 0, sz});
        append(soup, sx * sy * sz > 0 ? face : flipped(face));
    }
    for (int i = 0; i < level; ++i) {
        soup = split_in_four(soup);
    }
    for (std::size_t at = 0; at < soup.size(); at += 3) {
        const Xyz p = onto_sphere({soup[at], soup[at + 1], soup[at + 2]}, centre, radius);
        std::copy(p.begin(), p.end(), soup.begin() + static_cast<std::ptrdiff_t>(at));
    }
    return soup;
}

Soup prism(int quarters, double radius, double height) {
    const std::vector<Xyz> corners = polygon(quarters, radius);
    const auto raised = [&](Xyz p) { return Xyz{p[0], p[1], height}; };
    Soup soup;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Xyz a = corners[i];
        const Xyz b = corners[(i + 1) % corners.size()];
        add(soup, a, b, raised(b));
        add(soup, a, raised(b), raised(a));
        if (i > 0 && i + 1 < corners.size()) {
            add(soup, corners[0], b, a);
            add(soup, raised(corners[0]), raised(a), raised(b));
        }
    }
    return soup;
}

Soup random_soup(std::uint64_t seed, int triangles, std::uint64_t range) {
    std::mt19937_64 random(seed);
    Soup soup(9 * static_cast<std::size_t>(triangles));
    std::generate(soup.begin(), soup.end(), [&] { return small_integer(random, range); });
    return soup;
}

Soup random_tetrahedra(std::uint64_t seed, int count, std::uint64_t range) {
    std::mt19937_64 random(seed);
    const auto number = [&] { return small_integer(random, range); };
    Soup soup;
    for (int t = 0; t < count; ++t) {
        const Xyz corners[] = {{number(), number(), number()},
                               {number(), number(), number()},
                               {number(), number(), number()},
                               {number(), number(), number()}};
        append(soup, tetrahedron(corners[0], corners[1], corners[2], corners[3]));
    }
    return soup;
}

Soup shuffled(const Soup& soup, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<std::size_t> order(soup.size() / 9);
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {
        std::swap(order[i - 1], order[random() % i]);
    }
    Soup result;
    for (const std::size_t t : order) {
        const std::size_t first = random() % 3;
        add(result, corner(soup, t, first), corner(soup, t, (first + 1) % 3), corner(soup, t, (first + 2) % 3));
    }
    return result;
}

std::vector<float> floats(const Soup& soup) {
    return {soup.begin(), soup.end()};
}

Indexed indexed(const Soup& soup) {
    Indexed mesh;
    std::map<Xyz, std::uint32_t> known;
    for (std::size_t i = 0; i < soup.size() / 3; ++i) {
        const Xyz p = corner(soup, i / 3, i % 3);
        const auto [place, fresh] = known.try_emplace(p, static_cast<std::uint32_t>(known.size()));
        if (fresh) {
            mesh.xyz.insert(mesh.xyz.end(), p.begin(), p.end());
        }
        mesh.indices.push_back(place->second);
    }
    return mesh;
}

}  // namespace shapes
