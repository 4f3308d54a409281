// The files that the readers' golden cases read: one mesh of triangles, quads and larger polygons, written in every format
// with integer arithmetic alone. Large enough to be parsed by several tasks. Binary forms of text formats: tests/input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "golden/inputs.hpp"

namespace golden {

/// Coordinates are multiples of 1/64.
struct Polygons {
    std::vector<double> xyz;
    std::vector<std::vector<std::uint32_t>> faces;
    std::size_t points() const { return xyz.size() / 3; }
    std::size_t corners() const {
        std::size_t sum = 0;
        for (const auto& face : faces) {
            sum += face.size();
        }
        return sum;
    }
};

// One format each; coordinates of text have six decimals.
std::string binary_stl(const Soup& soup);
std::string text_stl(const Soup& soup);
/// Indices from the front and from the back, alone and with those of normals.
std::string obj(const Polygons& mesh);
std::string off(const Polygons& mesh);
std::string text_ply(const Polygons& mesh);
std::string little_ply(const Polygons& mesh);
std::string text_vtk(const Polygons& mesh);
std::string text_vtp(const Polygons& mesh);
/// The body as object 1, of which `items` are the build; in inches. Parts are stored, not deflated, since the bytes that
/// zlib makes differ between its versions.
std::string three_mf(const shapes::Indexed& body, const std::string& items);

/// Bytes by file name.
std::map<std::string, std::string> mesh_files();

}  // namespace golden
