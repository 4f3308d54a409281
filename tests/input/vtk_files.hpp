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

    std::vector<double> coordinates() const {
        std::vector<double> numbers;
        for (const auto& point : points) {
            numbers.insert(numbers.end(), point.begin(), point.end());
        }
        return numbers;
    }
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

/// The triangles that must be read: convex polygons as fans, strips with every other triangle the other way round.
inline Triangles triangles_of(const PolyData& data) {
    Triangles triangles;
    const auto add = [&](std::array<std::uint32_t, 3> corners) {
        auto& triangle = triangles.emplace_back();
        for (std::size_t i = 0; i < 9; ++i) {
            triangle[i] = data.points[corners[i / 3]][i % 3];
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
    return triangles;
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

/// Writes legacy files.
struct Legacy {
    bool text = true;
    int version = 3;
    std::string points = "float";
    std::string integers = "vtktypeint64";  ///< of offsets and connectivity, from version 5 on
    std::string extra{};                    ///< between points and cells

    Encoding encoding() const { return {text, true}; }
    std::string array(const std::string& type, const std::vector<double>& values) const {
        std::string bytes;
        for (const double value : values) {
            bytes += encoding().as(type, value);
        }
        return bytes + "\n";
    }
    std::string header() const {
        return "# vtk DataFile Version " + std::to_string(version) + (version == 5 ? ".1" : ".0") + "\na title\n" +
               (text ? "ASCII" : "BINARY") + "\nDATASET POLYDATA\n";
    }
    std::string cells(const std::string& name, const Cells& cells) const {
        if (cells.empty()) {
            return "";
        }
        std::vector<double> counted;
        std::vector<double> offsets{0};
        std::vector<double> corners;
        for (const auto& cell : cells) {
            counted.push_back(static_cast<double>(cell.size()));
            counted.insert(counted.end(), cell.begin(), cell.end());
            corners.insert(corners.end(), cell.begin(), cell.end());
            offsets.push_back(static_cast<double>(corners.size()));
        }
        if (version < 5) {
            return name + " " + std::to_string(cells.size()) + " " + std::to_string(counted.size()) + "\n" +
                   array("int", counted);
        }
        return name + " " + std::to_string(offsets.size()) + " " + std::to_string(corners.size()) + "\nOFFSETS " + integers +
               "\n" + array(integers, offsets) + "CONNECTIVITY " + integers + "\n" + array(integers, corners);
    }
    std::string operator()(const PolyData& data) const {
        return header() + "POINTS " + std::to_string(data.points.size()) + " " + points + "\n" +
               array(points, data.coordinates()) + extra + cells("POLYGONS", data.polygons) +
               cells("TRIANGLE_STRIPS", data.strips);
    }
};

}  // namespace lamella::vtk_test
