// Planes at the heights of a mesh's own vertices, and the checks for them. Surfaces from CT are normally like this: their
// vertices lie by the thousand on whole millimetres.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/slicing.hpp"
#include "oracle/oracle.hpp"

/// Every height at which a vertex lies, ascending and distinct on the grid.
inline std::vector<double> vertex_heights(const shapes::Soup& soup, double grid_mm) {
    std::vector<double> heights;
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        heights.push_back(soup[i]);
    }
    std::sort(heights.begin(), heights.end());
    const auto equal = [grid_mm](double a, double b) {
        return std::nearbyint(a / (2 * grid_mm)) == std::nearbyint(b / (2 * grid_mm));
    };
    heights.erase(std::unique(heights.begin(), heights.end(), equal), heights.end());
    return heights;
}

/// The first loss of a slice, in words, or empty. A layer must have as many segments as there are triangles with vertices
/// on both sides of its plane.
inline std::string lost_at_vertex_heights(const lamella::SliceResult& result, const shapes::Soup& soup) {
    const auto plane_above = [&](std::int32_t z) {
        return std::partition_point(result.layers.begin(), result.layers.end(),
                                    [z](const lamella::Layer& layer) { return layer.plane.z() < z; }) -
               result.layers.begin();
    };
    std::vector<std::int64_t> change(result.layers.size() + 1, 0);  // by layer: change in the number of triangles cut
    for (const oracle::Triangle& t : oracle::quantise(soup, result.info.grid_mm)) {
        const auto [low, high] = std::minmax({t[0].z, t[1].z, t[2].z});
        ++change[static_cast<std::size_t>(plane_above(low))];
        --change[static_cast<std::size_t>(plane_above(high))];
    }
    std::uint64_t cut = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        cut += static_cast<std::uint64_t>(change[l]);
        if (result.layers[l].segments != cut) {
            return "layer " + std::to_string(l) + " does not have " + std::to_string(cut) + " segments";
        }
    }
    return {};
}
