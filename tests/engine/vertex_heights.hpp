// Planes at the heights of a mesh's own vertices, and the checks for them. Surfaces from CT are normally like this: their
// vertices lie by the thousand on whole millimetres.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "lamella/lamella.hpp"

/// Every height at which a vertex lies, ascending and distinct on the grid.
template <class Number>
std::vector<double> vertex_heights(const std::vector<Number>& soup, double unit_mm) {
    std::vector<double> heights;
    for (std::size_t i = 2; i < soup.size(); i += 3) {
        heights.push_back(static_cast<double>(soup[i]));
    }
    std::sort(heights.begin(), heights.end());
    const auto equal = [unit_mm](double a, double b) {
        return std::nearbyint(a / (2 * unit_mm)) == std::nearbyint(b / (2 * unit_mm));
    };
    heights.erase(std::unique(heights.begin(), heights.end(), equal), heights.end());
    return heights;
}

/// The first loss of a slice, in words, or empty. A layer must have as many segments as there are triangles with vertices
/// on both sides of its plane.
template <class Number>
std::string lost_at_vertex_heights(const lamella::SliceResult& result, const std::vector<Number>& soup) {
    const auto on_grid = [&](Number mm) {
        return 2 * static_cast<std::int32_t>(std::nearbyint(static_cast<double>(mm) / (2 * result.info.grid_mm)));
    };
    const auto plane_above = [&](std::int32_t z) {
        const auto above = std::partition_point(result.layers.begin(), result.layers.end(),
                                                [z](const lamella::Layer& layer) { return layer.plane.z() < z; });
        return static_cast<std::size_t>(above - result.layers.begin());
    };
    std::vector<std::int64_t> change(result.layers.size() + 1, 0);  // by layer: change in the number of triangles cut
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        const auto [low, high] = std::minmax({on_grid(soup[t + 2]), on_grid(soup[t + 5]), on_grid(soup[t + 8])});
        ++change[plane_above(low)];
        --change[plane_above(high)];
    }
    std::int64_t cut = 0;
    for (std::size_t l = 0; l < result.layers.size(); ++l) {
        cut += change[l];
        if (static_cast<std::int64_t>(result.layers[l].segments) != cut) {
            return "layer " + std::to_string(l) + " cuts " + std::to_string(cut) + " triangles but has " +
                   std::to_string(result.layers[l].segments) + " segments";
        }
    }
    return {};
}
