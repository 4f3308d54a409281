#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "soup.hpp"

namespace lamella::models::test {

namespace {

using Bits = std::array<std::uint32_t, 3>;
using Edge = std::array<Bits, 2>;

Bits bits_of(const float* vertex) {
    Bits bits{};
    for (std::size_t i = 0; i < 3; ++i) {
        const float value = vertex[i] + 0.0F;  // both zeros become one
        std::memcpy(&bits[i], &value, sizeof value);
    }
    return bits;
}

std::array<float, 2> z_range(const float* triangle) {
    const auto [low, high] = std::minmax({triangle[2], triangle[5], triangle[8]});
    return {low, high};
}

// A tetrahedron oriented outwards.
const std::vector<float> tetrahedron{0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                     0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};

}  // namespace

bool closed_and_oriented(const std::vector<float>& soup) {
    std::vector<Edge> edges;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        for (std::size_t v = 0; v < 3; ++v) {
            edges.push_back({bits_of(&soup[t + 3 * v]), bits_of(&soup[t + 3 * ((v + 1) % 3)])});
        }
    }
    std::vector<Edge> opposites = edges;
    for (Edge& edge : opposites) {
        std::swap(edge[0], edge[1]);
    }
    std::sort(edges.begin(), edges.end());
    std::sort(opposites.begin(), opposites.end());
    return edges == opposites && std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

std::uint64_t degenerate_on_default_grid(const std::vector<float>& soup) {
    std::uint64_t count = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        std::array<std::array<long long, 3>, 3> v{};
        for (std::size_t i = 0; i < 9; ++i) {
            v[i / 3][i % 3] = std::llrint(static_cast<double>(soup[t + i]) * 0x1p19);
        }
        count += v[0] == v[1] || v[1] == v[2] || v[2] == v[0] ? 1 : 0;
    }
    return count;
}

double volume(const std::vector<float>& soup) {
    double sixfold = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        std::array<double, 9> v{};
        std::copy_n(soup.begin() + static_cast<std::ptrdiff_t>(t), 9, v.begin());
        sixfold +=
            v[0] * (v[4] * v[8] - v[5] * v[7]) + v[1] * (v[5] * v[6] - v[3] * v[8]) + v[2] * (v[3] * v[7] - v[4] * v[6]);
    }
    return sixfold / 6;
}

std::uint64_t crossings(const std::vector<float>& soup, double layer_height_mm) {
    double count = 0;
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        const auto [low, high] = z_range(&soup[t]);
        count += std::floor(static_cast<double>(high) / layer_height_mm - 0.5) -
                 std::floor(static_cast<double>(low) / layer_height_mm - 0.5);
    }
    return static_cast<std::uint64_t>(count);
}

bool ascending(const std::vector<float>& soup) {
    for (std::size_t t = 9; t < soup.size(); t += 9) {
        if (z_range(&soup[t])[0] < z_range(&soup[t - 9])[0]) {
            return false;
        }
    }
    return true;
}

TEST_CASE("the checks of generated meshes detect damaged meshes", "[models]") {
    CHECK(closed_and_oriented(tetrahedron));
    CHECK(volume(tetrahedron) == Approx(1.0 / 6));
    CHECK(crossings(tetrahedron, 0.5) == 6);

    std::vector<float> open = tetrahedron;
    open.resize(27);
    CHECK_FALSE(closed_and_oriented(open));

    std::vector<float> flipped = tetrahedron;
    std::swap_ranges(flipped.begin(), flipped.begin() + 3, flipped.begin() + 3);
    CHECK_FALSE(closed_and_oriented(flipped));

    std::vector<float> doubled = tetrahedron;
    doubled.insert(doubled.end(), tetrahedron.begin(), tetrahedron.end());
    CHECK_FALSE(closed_and_oriented(doubled));

    std::vector<float> descending(tetrahedron.rbegin(), tetrahedron.rend());
    descending[2] = descending[5] = descending[8] = 1;
    CHECK(ascending(tetrahedron));
    CHECK_FALSE(ascending(descending));

    CHECK(degenerate_on_default_grid(tetrahedron) == 0);
    CHECK(degenerate_on_default_grid({0, 0, 0, 1e-7F, 0, 0, 1, 1, 1}) == 1);
}

}  // namespace lamella::models::test
