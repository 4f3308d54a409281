// One sheet of triangles or quads in each format, and in each form that a reader takes another way through.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "golden/mesh_files.hpp"
#include "zip.hpp"

namespace lamella::input_test {

/// A sheet of side * side quads, or of twice as many triangles, which are their fans.
inline golden::Polygons sheet(std::uint32_t side, bool quads) {
    golden::Polygons mesh;
    for (std::uint32_t i = 0; i < (side + 1) * (side + 1); ++i) {
        const std::uint32_t x = i % (side + 1);
        const std::uint32_t y = i / (side + 1);
        mesh.xyz.insert(mesh.xyz.end(), {double(x), double(y), (x * y) % 7 / 64.0});
    }
    for (std::uint32_t i = 0; i < side * side; ++i) {
        const std::uint32_t first = i / side * (side + 1) + i % side;
        const std::uint32_t above = first + side + 1;
        if (quads) {
            mesh.faces.push_back({first, first + 1, above + 1, above});
        } else {
            mesh.faces.push_back({first, first + 1, above + 1});
            mesh.faces.push_back({first, above + 1, above});
        }
    }
    return mesh;
}

inline shapes::Indexed indexed_sheet(std::uint32_t side) {
    const golden::Polygons mesh = sheet(side, false);
    shapes::Indexed indexed{mesh.xyz, {}};
    for (const auto& face : mesh.faces) {
        indexed.indices.insert(indexed.indices.end(), face.begin(), face.end());
    }
    return indexed;
}

inline shapes::Soup sheet_soup(std::uint32_t side) {
    const shapes::Indexed mesh = indexed_sheet(side);
    shapes::Soup soup;
    for (const std::uint32_t index : mesh.indices) {
        soup.insert(soup.end(), mesh.xyz.begin() + 3 * index, mesh.xyz.begin() + 3 * index + 3);
    }
    return soup;
}

/// Behind the header another white space than the usual one.
inline std::string respaced(std::string text, const std::string& header_end, char usual, char other) {
    const std::size_t begin = text.find(header_end) + header_end.size();
    std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), usual, other);
    return text;
}

/// The build holds the sheet so many times, in inches.
inline std::string three_mf_sheets(std::uint32_t side, int items) {
    std::string build;
    for (int i = 0; i < items; ++i) {
        build += item(1, "transform=\"1 0 0 0 1 0 0 0 1 0 0 " + std::to_string(i) + "\"");
    }
    return golden::three_mf(indexed_sheet(side), build);
}

struct SheetFile {
    const char* name;
    std::function<std::string(std::uint32_t side)> bytes;
    bool once = true;  ///< it holds the sheet once
};

inline const std::vector<SheetFile> sheet_files = {
    {"binary.stl", [](auto side) { return golden::binary_stl(sheet_soup(side)); }},
    {"text.stl", [](auto side) { return golden::text_stl(sheet_soup(side)); }},
    {"sloppy.stl", [](auto side) { return replaced(golden::text_stl(sheet_soup(side)), " outer loop\n", ""); }},
    {"triangles.obj", [](auto side) { return golden::obj(sheet(side, false)); }},
    {"quads.obj", [](auto side) { return golden::obj(sheet(side, true)); }},
    {"lines.off", [](auto side) { return golden::off(sheet(side, false)); }},
    {"words.off", [](auto side) { return respaced(golden::off(sheet(side, false)), " 0\n", '\n', ' '); }},
    {"lines.ply", [](auto side) { return golden::text_ply(sheet(side, false)); }},
    {"words.ply", [](auto side) { return respaced(golden::text_ply(sheet(side, false)), "end_header\n", ' ', '\n'); }},
    {"quads.ply", [](auto side) { return golden::little_ply(sheet(side, true)); }},
    {"text.vtk", [](auto side) { return golden::text_vtk(sheet(side, true)); }},
    {"text.vtp", [](auto side) { return golden::text_vtp(sheet(side, true)); }},
    {"one.3mf", [](auto side) { return three_mf_sheets(side, 1); }},
    {"quads.obj.gz", [](auto side) { return deflated(golden::obj(sheet(side, true)), 16 + MAX_WBITS); }},
    {"many.3mf", [](auto side) { return three_mf_sheets(side, 20); }, false},
    {"name.stl",
     [](auto side) { return ascii_stl(numbered_facets(1)) + "solid" + repeated(" of a long name", 4 * side * side) + "\n"; },
     false},
    {"comments.stl", [](auto side) { return ascii_stl(numbered_facets(1)) + repeated("a comment\n", 4 * side * side); },
     false},
};

}  // namespace lamella::input_test
