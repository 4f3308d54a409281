// Small meshes for tests. Exact or correctly rounded arithmetic gives the same bytes everywhere.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <vector>

#include "lamella/mesh.hpp"

namespace shapes {

/// Nine numbers a triangle, counter-clockwise as seen from outside.
using Soup = std::vector<double>;
using Xyz = std::array<double, 3>;

Soup triangle(Xyz a, Xyz b, Xyz c);
Soup quad(Xyz a, Xyz b, Xyz c, Xyz d);
/// With d on the inner side of a, b, c.
Soup tetrahedron(Xyz a, Xyz b, Xyz c, Xyz d);
/// Upright, 10 mm high, over the line from one place to the other, with the solid on its left.
Soup wall(std::array<double, 2> from, std::array<double, 2> to);
/// Such walls over a closed polygon, without floor and ceiling.
Soup walls(const std::vector<std::array<double, 2>>& polygon);
Soup joined(std::initializer_list<Soup> parts);
void append(Soup& soup, const Soup& more);
Soup flipped(Soup soup);
Soup moved(Soup soup, Xyz by);
Soup scaled(Soup soup, Xyz by);

/// Without triangles [from, from + count).
Soup without(Soup soup, std::size_t from, std::size_t count);
/// These triangles alone.
Soup only(const Soup& soup, std::size_t from, std::size_t count);

/// Twelve triangles, in pairs: bottom, top, front (low y), right, back, left. Every side's diagonal rises
/// counter-clockwise.
Soup box(Xyz low, Xyz high);

/// An octahedron whose faces are split into four `level` times and pushed out to the radius: 8·4^level triangles.
Soup octasphere(Xyz centre, double radius, int level);

/// 2·quarters·4 side facets from z = 0 to the height, and fans for the caps.
Soup prism(int quarters, double radius, double height);

/// Triangles with corners on integers in [0, range]. Corners often coincide, and most edges are unbalanced.
Soup random_soup(std::uint64_t seed, int triangles, std::uint64_t range);

/// Tetrahedra with such corners, oriented outwards or inwards. Every edge has as many faces one way as the other, often
/// more than two in all.
Soup random_tetrahedra(std::uint64_t seed, int count, std::uint64_t range);

/// The same triangles in another order, each starting at another of its corners.
Soup shuffled(const Soup& soup, std::uint64_t seed);

std::vector<float> floats(const Soup& soup);

/// From an odd address on: records of `stride` bytes with `per_record` numbers each, without spare bytes after the last.
template <class T>
std::vector<std::byte> records(const std::vector<T>& numbers, std::size_t per_record, std::size_t stride) {
    const std::size_t bytes = per_record * sizeof(T);
    std::vector<std::byte> made(1 + numbers.size() / per_record * stride - (stride - bytes), std::byte{0xFF});
    for (std::size_t i = 0; i < numbers.size() / per_record; ++i) {
        std::memcpy(made.data() + 1 + i * stride, numbers.data() + i * per_record, bytes);
    }
    return made;
}

struct Indexed {
    std::vector<double> xyz;
    std::vector<std::uint32_t> indices;
    lamella::MeshView view() const { return lamella::MeshView::indexed(std::span<const double>(xyz), indices); }
};
Indexed indexed(const Soup& soup);

}  // namespace shapes
