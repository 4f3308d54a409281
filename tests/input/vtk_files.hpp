// Polygonal data as the files of VTK hold them, written in every form that the readers know.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "read.hpp"

namespace lamella::vtk_test {

using namespace input_test;
using input_test::triangles_of;

using Cells = std::vector<std::vector<std::uint32_t>>;

struct PolyData {
    std::vector<std::array<double, 3>> points;
    Cells polygons;
    Cells strips;
};

/// From 0 to `edge` mm, six quads.
inline PolyData cube(double edge = 10) {
    PolyData data;
    for (const double z : {0.0, edge}) {
        for (const double y : {0.0, edge}) {
            data.points.insert(data.points.end(), {{0, y, z}, {edge, y, z}});
        }
    }
    data.polygons = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    return data;
}

inline PolyData triangle(double edge) {
    return {{{0, 0, 0}, {edge, 0, 0}, {0, edge, 0}}, {{0, 1, 2}}, {}};
}

inline PolyData cube_with_strip() {
    PolyData data = cube();
    data.strips = {{0, 1, 2, 3, 4, 5}, {7, 6, 5}};
    return data;
}

/// Triangles and quads, enough of them for many tasks.
inline PolyData sheet(std::uint32_t side) {
    PolyData data;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            data.points.push_back({static_cast<double>(x), static_cast<double>(y), (x * y) % 7 * 0.25});
        }
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t at = y * (side + 1) + x;
            if (y < side / 2) {  // blocks of triangles alone come first
                data.polygons.push_back({at, at + 1, at + side + 1});
            } else {
                data.polygons.push_back({at, at + 1, at + side + 2, at + side + 1});
            }
        }
    }
    return data;
}

/// What must be read: convex polygons as fans, strips with every other triangle the other way round.
inline std::vector<Facet> triangles_of(const PolyData& data) {
    std::vector<Facet> facets;
    const auto add = [&](std::array<std::uint32_t, 3> corners) {
        Facet& facet = facets.emplace_back();
        for (std::size_t i = 0; i < 9; ++i) {
            facet[i] = static_cast<float>(data.points[corners[i / 3]][i % 3]);
        }
    };
    for (const auto& cell : data.polygons) {
        for (std::size_t i = 2; i < cell.size(); ++i) {
            add({cell[0], cell[i - 1], cell[i]});
        }
    }
    for (const auto& cell : data.strips) {
        for (std::size_t i = 2; i < cell.size(); ++i) {
            add(i % 2 == 0 ? std::array{cell[i - 2], cell[i - 1], cell[i]} : std::array{cell[i - 1], cell[i - 2], cell[i]});
        }
    }
    return facets;
}

/// The triangles of a file that must be readable.
inline std::vector<Facet> read_triangles(const std::filesystem::path& path) {
    return input_test::read_triangles<float>(path);
}

/// Numbers as text or bytes, under one of VTK's names of types.
struct Encoding {
    bool text = true;
    bool big_endian = true;

    /// `type` as legacy files or XML files spell it.
    template <class Number>
    std::string as(const std::string& type, Number value) const {
        return as_type(type, value,
                       [this](auto number) { return text ? std::to_string(number) + " " : bytes_of(number, big_endian); });
    }
};

}  // namespace lamella::vtk_test
