#include "mesh_writers.hpp"

#include "written_text.hpp"
#include "xml_writers.hpp"

namespace lamella::bench {

namespace {

std::uint64_t write_stl_ascii(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    text << "solid mesh\n";
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text << "facet normal 0 0 0\n outer loop\n";
        for (const std::uint32_t corner : corners) {
            const auto [x, y, z] = vertex_of(mesh, corner);
            text << "  vertex " << x << " " << y << " " << z << "\n";
        }
        text << " endloop\nendfacet\n";
    });
    text << "endsolid mesh\n";
    return save(text.all(), file);
}

std::uint64_t write_stl_binary(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    text << std::string(80, ' ');
    text.bytes(static_cast<std::uint32_t>(triangles_of(mesh)));
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text << std::string_view("\0\0\0\0\0\0\0\0\0\0\0\0", 12);
        for (const std::uint32_t corner : corners) {
            for (const float coordinate : vertex_of(mesh, corner)) {
                text.bytes(coordinate);
            }
        }
        text << std::string_view("\0\0", 2);
    });
    return save(text.all(), file);
}

/// Writes lines "before X Y Z" and "before A B C".
void put_lines(Text& text, const WeldedMesh& mesh, std::string_view before_vertex, std::string_view before_triangle,
               std::uint32_t first) {
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        text << before_vertex << xyz[0] << " " << xyz[1] << " " << xyz[2] << "\n";
    });
    for_triangles(
        mesh,
        [&](const std::array<std::uint32_t, 3>& corners) {
            text << before_triangle << corners[0] << " " << corners[1] << " " << corners[2] << "\n";
        },
        first);
}

std::uint64_t write_obj(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    text << "# a mesh\no mesh\n";
    put_lines(text, mesh, "v ", "f ", 1);
    return save(text.all(), file);
}

std::uint64_t write_off(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    text << "OFF\n" << mesh.vertex_count << " " << triangles_of(mesh) << " 0\n";
    put_lines(text, mesh, "", "3 ", 0);
    return save(text.all(), file);
}

Text ply_header(const WeldedMesh& mesh, std::string_view encoding) {
    Text text;
    text << "ply\nformat " << encoding << " 1.0\nelement vertex " << mesh.vertex_count
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << triangles_of(mesh)
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    return text;
}

std::uint64_t write_ply_ascii(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text = ply_header(mesh, "ascii");
    put_lines(text, mesh, "", "3 ", 0);
    return save(text.all(), file);
}

template <std::endian order>
std::uint64_t write_ply_binary(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text = ply_header(mesh, order == std::endian::little ? "binary_little_endian" : "binary_big_endian");
    for_vertices(
        mesh, [&](const std::array<float, 3>& xyz) { text.bytes(xyz[0], order).bytes(xyz[1], order).bytes(xyz[2], order); });
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text.bytes(std::uint8_t{3}).bytes(corners[0], order).bytes(corners[1], order).bytes(corners[2], order);
    });
    return save(text.all(), file);
}

std::uint64_t write_vtk_ascii(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    text << "# vtk DataFile Version 4.2\nmesh\nASCII\nDATASET POLYDATA\nPOINTS " << mesh.vertex_count << " float\n";
    std::uint64_t on_line = 0;
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        text << xyz[0] << " " << xyz[1] << " " << xyz[2] << (++on_line % 3 == 0 ? " \n" : " ");
    });
    text << "\nPOLYGONS " << triangles_of(mesh) << " " << 4 * triangles_of(mesh) << "\n";
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text << "3 " << corners[0] << " " << corners[1] << " " << corners[2] << " \n";
    });
    return save(text.all(), file);
}

void put_vtk_points(Text& text, const WeldedMesh& mesh, std::string_view version) {
    text << "# vtk DataFile Version " << version << "\nmesh\nBINARY\nDATASET POLYDATA\nPOINTS " << mesh.vertex_count
         << " float\n";
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        for (const float coordinate : xyz) {
            text.bytes(coordinate, std::endian::big);
        }
    });
}

/// Writes each cell's number of corners, then the corners.
std::uint64_t write_vtk_binary(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    put_vtk_points(text, mesh, "4.2");
    text << "\nPOLYGONS " << triangles_of(mesh) << " " << 4 * triangles_of(mesh) << "\n";
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text.bytes(std::uint32_t{3}, std::endian::big);
        for (const std::uint32_t corner : corners) {
            text.bytes(corner, std::endian::big);
        }
    });
    return save(text.all(), file);
}

/// Writes the offsets, then all corners.
std::uint64_t write_vtk5_binary(const WeldedMesh& mesh, const std::filesystem::path& file) {
    Text text;
    put_vtk_points(text, mesh, "5.1");
    text << "\nPOLYGONS " << triangles_of(mesh) + 1 << " " << mesh.indices.size() << "\nOFFSETS vtktypeint64\n";
    for (std::uint64_t end = 0; end <= mesh.indices.size(); end += 3) {
        text.bytes(end, std::endian::big);
    }
    text << "\nCONNECTIVITY vtktypeint64\n";
    for (const std::uint32_t corner : mesh.indices) {
        text.bytes(std::uint64_t{corner}, std::endian::big);
    }
    return save(text.all(), file);
}

constexpr std::array writers = {
    MeshWriter{"stl_ascii", ".stl", Encoding::text, write_stl_ascii},
    MeshWriter{"obj", ".obj", Encoding::text, write_obj},
    MeshWriter{"off", ".off", Encoding::text, write_off},
    MeshWriter{"ply_ascii", ".ply", Encoding::text, write_ply_ascii},
    MeshWriter{"vtk_ascii", ".vtk", Encoding::text, write_vtk_ascii},
    MeshWriter{"vtp_ascii", ".vtp", Encoding::text, write_vtp_ascii},
    MeshWriter{"stl_binary", ".stl", Encoding::binary, write_stl_binary},
    MeshWriter{"ply_little_endian", ".ply", Encoding::binary, write_ply_binary<std::endian::little>},
    MeshWriter{"ply_big_endian", ".ply", Encoding::binary, write_ply_binary<std::endian::big>},
    MeshWriter{"vtk_binary", ".vtk", Encoding::binary, write_vtk_binary},
    MeshWriter{"vtk5_binary", ".vtk", Encoding::binary, write_vtk5_binary},
    MeshWriter{"vtp_raw", ".vtp", Encoding::binary, write_vtp_raw},
    MeshWriter{"vtp_base64", ".vtp", Encoding::packed, write_vtp_base64},
    MeshWriter{"vtp_zlib", ".vtp", Encoding::packed, write_vtp_zlib},
    MeshWriter{"3mf", ".3mf", Encoding::packed, write_3mf},
};

}  // namespace

std::span<const MeshWriter> mesh_writers() noexcept {
    return writers;
}

}  // namespace lamella::bench
