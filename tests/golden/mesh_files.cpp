#include "golden/mesh_files.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "golden/inputs.hpp"
#include "input/zip.hpp"

namespace golden {

namespace {

/// A closed body, a sheet of bent quads, and an L of six corners.
Polygons all_kinds() {
    shapes::Indexed body = shapes::indexed(mesh("voxel body"));
    Polygons mesh{std::move(body.xyz), {}};
    for (std::size_t i = 0; i < body.indices.size(); i += 3) {
        mesh.faces.push_back({body.indices[i], body.indices[i + 1], body.indices[i + 2]});
    }
    constexpr std::uint32_t side = 40;
    SplitMix random(21);
    const auto first = static_cast<std::uint32_t>(mesh.points());
    for (std::uint32_t i = 0; i < side * side; ++i) {
        mesh.xyz.insert(mesh.xyz.end(), {double(i % side), double(i / side), random.between(-99, 99) / 64.0});
    }
    for (std::uint32_t i = 0; i + side + 1 < side * side; ++i) {
        if (i % side + 1 < side) {
            mesh.faces.push_back({first + i, first + i + 1, first + i + side + 1, first + i + side});
        }
    }
    const auto corner = static_cast<std::uint32_t>(mesh.points());
    mesh.xyz.insert(mesh.xyz.end(), {0, 0, 50, 9, 0, 50, 9, 3, 50, 3, 3, 50, 3, 9, 50, 0, 9, 50});
    mesh.faces.push_back({corner, corner + 1, corner + 2, corner + 3, corner + 4, corner + 5});
    return mesh;
}

/// Exact: 1/64 has six decimals.
std::string decimal(double number) {
    const auto units = static_cast<std::int64_t>(number * 64);
    const std::int64_t magnitude = units < 0 ? -units : units;
    const std::string fraction = std::to_string(1'000'000 + magnitude % 64 * 15'625);
    return (units < 0 ? "-" : "") + std::to_string(magnitude / 64) + "." + fraction.substr(1);
}

std::string decimals(const Polygons& mesh, std::size_t point) {
    return decimal(mesh.xyz[3 * point]) + " " + decimal(mesh.xyz[3 * point + 1]) + " " + decimal(mesh.xyz[3 * point + 2]);
}

template <class Number>
std::string little(Number number) {
    std::string bytes(sizeof number, '\0');
    std::memcpy(bytes.data(), &number, sizeof number);
    return bytes;
}

/// One line a face: the number of its corners, and their indices.
std::string counted_faces(const Polygons& mesh) {
    std::string text;
    for (const auto& face : mesh.faces) {
        text += std::to_string(face.size());
        for (const std::uint32_t index : face) {
            text += " " + std::to_string(index);
        }
        text += "\n";
    }
    return text;
}

std::string points_text(const Polygons& mesh) {
    std::string text;
    for (std::size_t i = 0; i < mesh.points(); ++i) {
        text += decimals(mesh, i) + "\n";
    }
    return text;
}

std::string ply_header(const Polygons& mesh, const std::string& encoding, const std::string& number) {
    return "ply\nformat " + encoding + " 1.0\ncomment unit mm\nelement vertex " + std::to_string(mesh.points()) +
           "\nproperty " + number + " x\nproperty " + number + " y\nproperty " + number + " z\nelement face " +
           std::to_string(mesh.faces.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

}  // namespace

std::string binary_stl(const Soup& soup) {
    std::string bytes = std::string(80, ' ') + little(static_cast<std::uint32_t>(soup.size() / 9));
    for (std::size_t t = 0; t < soup.size(); t += 9) {
        bytes.append(12, '\0');
        for (std::size_t i = 0; i < 9; ++i) {
            bytes += little(static_cast<float>(soup[t + i]));
        }
        bytes.append(2, '\0');
    }
    return bytes;
}

std::string text_stl(const Soup& soup) {
    std::string text = "solid body\n";
    for (std::size_t at = 0; at < soup.size(); at += 3) {
        text += at % 9 == 0 ? "facet normal 0 0 1\n outer loop\n" : "";
        text += "  vertex " + decimal(soup[at]) + " " + decimal(soup[at + 1]) + " " + decimal(soup[at + 2]) + "\n";
        text += at % 9 == 6 ? " endloop\nendfacet\n" : "";
    }
    return text + "endsolid body\n";
}

std::string obj(const Polygons& mesh) {
    std::string text = "# body\no body\nvn 0 0 1\n";
    for (std::size_t i = 0; i < mesh.points(); ++i) {
        text += "v " + decimals(mesh, i) + "\n";
    }
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        text += "f";
        for (const std::uint32_t index : mesh.faces[f]) {
            text += " " + (f % 3 == 2 ? "-" + std::to_string(mesh.points() - index) : std::to_string(index + 1));
            text += f % 3 == 1 ? "//1" : "";
        }
        text += "\n";
    }
    return text;
}

std::string off(const Polygons& mesh) {
    return "OFF\n" + std::to_string(mesh.points()) + " " + std::to_string(mesh.faces.size()) + " 0\n" + points_text(mesh) +
           counted_faces(mesh);
}

std::string text_ply(const Polygons& mesh) {
    return ply_header(mesh, "ascii", "double") + points_text(mesh) + counted_faces(mesh);
}

std::string little_ply(const Polygons& mesh) {
    std::string bytes = ply_header(mesh, "binary_little_endian", "float");
    for (const double coordinate : mesh.xyz) {
        bytes += little(static_cast<float>(coordinate));
    }
    for (const auto& face : mesh.faces) {
        bytes += static_cast<char>(face.size());
        for (const std::uint32_t index : face) {
            bytes += little(index);
        }
    }
    return bytes;
}

std::string text_vtk(const Polygons& mesh) {
    return "# vtk DataFile Version 3.0\nbody\nASCII\nDATASET POLYDATA\nPOINTS " + std::to_string(mesh.points()) +
           " float\n" + points_text(mesh) + "POLYGONS " + std::to_string(mesh.faces.size()) + " " +
           std::to_string(mesh.faces.size() + mesh.corners()) + "\n" + counted_faces(mesh);
}

std::string text_vtp(const Polygons& mesh) {
    std::string corners;
    std::string offsets;
    std::size_t end = 0;
    for (const auto& face : mesh.faces) {
        for (const std::uint32_t index : face) {
            corners += std::to_string(index) + " ";
        }
        corners += "\n";
        offsets += std::to_string(end += face.size()) + "\n";
    }
    const auto array = [](const std::string& attributes, const std::string& content) {
        return "<DataArray " + attributes + " format=\"ascii\">" + content + "</DataArray>\n";
    };
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
           "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
           std::to_string(mesh.points()) +
           "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
           std::to_string(mesh.faces.size()) + "\">\n<Points>\n" +
           array("type=\"Float32\" NumberOfComponents=\"3\"", points_text(mesh)) + "</Points>\n<Polys>\n" +
           array("type=\"Int64\" Name=\"connectivity\"", corners) + array("type=\"Int64\" Name=\"offsets\"", offsets) +
           "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

std::string three_mf(const shapes::Indexed& body, const std::string& items) {
    using namespace lamella::input_test;
    std::string text = "<mesh><vertices>\n";
    for (std::size_t i = 0; i < body.xyz.size(); i += 3) {
        text += "<vertex x=\"" + decimal(body.xyz[i]) + "\" y=\"" + decimal(body.xyz[i + 1]) + "\" z=\"" +
                decimal(body.xyz[i + 2]) + "\"/>\n";
    }
    text += "</vertices><triangles>\n";
    for (std::size_t i = 0; i < body.indices.size(); i += 3) {
        text += "<triangle v1=\"" + std::to_string(body.indices[i]) + "\" v2=\"" + std::to_string(body.indices[i + 1]) +
                "\" v3=\"" + std::to_string(body.indices[i + 2]) + "\"/>\n";
    }
    const std::string model = model_text(object(1, text + "</triangles></mesh>"), items, "unit=\"inch\"");
    std::vector<ZipPart> parts = {content_types(), relationships(), {"3D/3dmodel.model", model}};
    for (ZipPart& part : parts) {
        part.deflated = false;
    }
    return zip(parts);
}

std::map<std::string, std::string> mesh_files() {
    using lamella::input_test::item;
    const std::string mirrored = "transform=\"0 1 0 1 0 0 0 0 0.5 3 4 -2\"";  // and turned and moved
    const Soup body = mesh("voxel body");
    const Polygons polygons = all_kinds();
    return {{"binary.stl", binary_stl(body)},
            {"text.stl", text_stl(body)},
            {"polygons.obj", obj(polygons)},
            {"polygons.off", off(polygons)},
            {"text.ply", text_ply(polygons)},
            {"little.ply", little_ply(polygons)},
            {"text.vtk", text_vtk(polygons)},
            {"text.vtp", text_vtp(polygons)},
            {"bodies.3mf", three_mf(shapes::indexed(body), item(1) + item(1, mirrored))}};
}

}  // namespace golden
