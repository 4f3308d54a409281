// Soups drawn from the fuzzer's bytes, with corners on small integers, so that corners often coincide.
#pragma once

#include <algorithm>
#include <array>

#include "bytes.hpp"

namespace fuzz {

using Corner = std::array<double, 3>;
using Triangle = std::array<Corner, 3>;

inline Corner corner(Bytes& bytes, double step_mm) {
    const unsigned xy = bytes.next();
    const auto at = [step_mm](unsigned integer) { return step_mm * (static_cast<double>(integer) - 4); };
    return {at(xy % 9), at(xy / 16 % 9), at(bytes.below(9))};
}

/// Adds a triangle, or the four faces of a tetrahedron: single triangles rarely form closed contours.
inline void add_shape(Bytes& bytes, bool solid, double step_mm, std::vector<Triangle>& triangles) {
    const Corner a = corner(bytes, step_mm);
    const Corner b = corner(bytes, step_mm);
    const Corner c = corner(bytes, step_mm);
    triangles.push_back({a, b, c});
    if (solid) {
        const Corner d = corner(bytes, step_mm);
        triangles.insert(triangles.end(), {{a, c, d}, {c, b, d}, {b, a, d}});
    }
}

/// The same triangles in another order, each starting at another of its corners.
inline void shuffle_soup(std::vector<Triangle>& triangles, std::uint32_t seed) {
    shuffle(triangles, seed);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        Triangle& corners = triangles[t];
        std::rotate(corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(t % 3), corners.end());
    }
}

template <class Number>
std::vector<Number> soup_of(const std::vector<Triangle>& triangles) {
    std::vector<Number> soup;
    for (const Triangle& triangle : triangles) {
        for (const Corner& at : triangle) {
            soup.insert(soup.end(), {static_cast<Number>(at[0]), static_cast<Number>(at[1]), static_cast<Number>(at[2])});
        }
    }
    return soup;
}

}  // namespace fuzz
