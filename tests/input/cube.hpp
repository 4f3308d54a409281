// One cube, as the readers of text know it: what every form of it must give.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "read.hpp"

namespace lamella::input_test {

using Corner = std::array<float, 3>;

inline constexpr std::array<Corner, 8> cube_corners = {{{0, 0, 0},
                                                        {8, 0, 0},
                                                        {8, 8, 0},
                                                        {0, 8, 0},  //
                                                        {0, 0, 8.5F},
                                                        {8, 0, 8.5F},
                                                        {8, 8, 8.5F},
                                                        {0, 8, 8.5F}}};
inline constexpr std::array<std::array<std::uint32_t, 4>, 6> cube_sides = {
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

inline std::string cube_corner_text(std::size_t v) {
    std::string text;
    for (const float value : cube_corners[v]) {
        text += (text.empty() ? "" : " ") + std::to_string(value);
    }
    return text;
}

/// Of the slices of the cube as STL.
inline std::uint64_t cube_hash() {
    std::vector<Facet> facets;
    for (const auto& side : cube_sides) {
        for (const std::size_t i : {1U, 2U}) {
            Facet& facet = facets.emplace_back();
            const std::array corners = {cube_corners[side[0]], cube_corners[side[i]], cube_corners[side[i + 1]]};
            std::memcpy(facet.data(), corners.data(), sizeof facet);
        }
    }
    return hash_of(dir.write("cube.stl", binary_stl(facets)));
}

}  // namespace lamella::input_test
