// One sheet of triangles or quads in each format, and in each form that a reader takes another way through.
#pragma once

#include <functional>

#include "mesh_files.hpp"

namespace lamella::input_test {

/// Another white space than the usual one, after the header.
inline std::string respaced(std::string text, const std::string& header_end, char usual, char other) {
    const std::size_t begin = text.find(header_end) + header_end.size();
    std::replace(text.begin() + static_cast<std::ptrdiff_t>(begin), text.end(), usual, other);
    return text;
}

/// The build holds the sheet so many times, in inches. Stored, as deflating takes long.
inline std::string three_mf_sheets(const PolygonMesh& sheet, int items) {
    std::string build;
    for (int i = 0; i < items; ++i) {
        build += item(1, "transform=\"1 0 0 0 1 0 0 0 1 0 0 " + std::to_string(i) + "\"");
    }
    std::vector<ZipPart> parts = package_parts(model_text(object(1, mesh_xml(sheet)), build, "unit=\"inch\""));
    parts.back().deflated = false;
    return zip(parts);
}

struct SheetFile {
    const char* name;
    std::function<std::string(const PolygonMesh& triangles, const PolygonMesh& quads, std::size_t points)> bytes;
    bool once = true;  ///< it holds the sheet once
};

inline std::string bytes_of(const SheetFile& file, std::uint32_t side) {
    return file.bytes(sheet(side, side * side), sheet(side, 0), 4 * std::size_t{side} * side);
}

inline Soup soup_of(const PolygonMesh& mesh) {
    Soup soup;
    for (const auto& triangle : mesh.triangles()) {
        soup.insert(soup.end(), triangle.begin(), triangle.end());
    }
    return soup;
}

inline const std::vector<SheetFile> sheet_files = {
    {"binary.stl", [](auto& t, auto&, auto) { return binary_stl(soup_of(t)); }},
    {"text.stl", [](auto& t, auto&, auto) { return text_stl(soup_of(t)); }},
    {"sloppy.stl", [](auto& t, auto&, auto) { return replaced(text_stl(soup_of(t)), " outer loop\n", ""); }},
    {"triangles.obj", [](auto& t, auto&, auto) { return obj(t); }},
    {"quads.obj", [](auto&, auto& q, auto) { return obj(q); }},
    {"lines.off", [](auto& t, auto&, auto) { return off(t); }},
    {"words.off", [](auto& t, auto&, auto) { return respaced(off(t), " 0\n", '\n', ' '); }},
    {"lines.ply", [](auto& t, auto&, auto) { return Ply{.coordinate = "double"}(t); }},
    {"words.ply", [](auto& t, auto&, auto) { return respaced(Ply{.coordinate = "double"}(t), "end_header\n", ' ', '\n'); }},
    {"quads.ply", [](auto&, auto& q, auto) { return Ply{.encoding = "binary_little_endian"}(q); }},
    {"text.vtk", [](auto&, auto& q, auto) { return Vtk{}(q); }},
    {"text.vtp", [](auto&, auto& q, auto) { return Vtp{}({q}); }},
    {"base64.gii", [](auto& t, auto&, auto) { return Gifti{"Base64Binary"}(t); }},
    {"zlib.gii",
     [](auto& t, auto&, auto) {
         return Gifti{"GZipBase64Binary", true, true}(t);
     }},
    {"a.pial", [](auto& t, auto&, auto) { return freesurfer(t); }},
    {"a.glb", [](auto& t, auto&, auto) { return glb(t); }},
    {"one.3mf", [](auto& t, auto&, auto) { return three_mf_sheets(t, 1); }},
    {"quads.obj.gz", [](auto&, auto& q, auto) { return gzipped(obj(q)); }},
    {"many.3mf", [](auto& t, auto&, auto) { return three_mf_sheets(t, 20); }, false},
    {"name.stl",
     [](auto&, auto&, auto n) { return text_stl(numbered_facets(1)) + "solid" + repeated(" of a long name", n) + "\n"; },
     false},
    {"comments.stl", [](auto&, auto&, auto n) { return text_stl(numbered_facets(1)) + repeated("a comment\n", n); }, false},
};

}  // namespace lamella::input_test
