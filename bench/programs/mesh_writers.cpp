#include "mesh_writers.hpp"

#include <zip.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string>

namespace lamella::bench {

namespace {

/// What becomes of a file, piece by piece.
class Text {
public:
    Text& operator<<(std::string_view piece) {
        all_ += piece;
        return *this;
    }
    /// The shortest decimals that mean the number.
    template <class Number>
    requires std::is_arithmetic_v<Number> Text& operator<<(Number number) {
        std::array<char, 32> digits;
        all_.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
        return *this;
    }
    /// The bytes of the number.
    template <class Number>
    Text& bytes(Number number, std::endian order = std::endian::little) {
        std::array<char, sizeof(Number)> raw;
        std::memcpy(raw.data(), &number, sizeof number);
        if (order != std::endian::native) {
            std::reverse(raw.begin(), raw.end());
        }
        all_.append(raw.data(), raw.size());
        return *this;
    }
    const std::string& all() const noexcept { return all_; }

private:
    std::string all_;
};

std::array<float, 3> vertex_of(const WeldedMesh& mesh, std::uint64_t vertex) {
    std::array<float, 3> xyz;
    std::memcpy(xyz.data(), mesh.coordinates.data() + vertex * sizeof xyz, sizeof xyz);
    return xyz;
}

template <class Write>
void for_vertices(const WeldedMesh& mesh, const Write& write) {
    for (std::uint64_t vertex = 0; vertex < mesh.vertices; ++vertex) {
        write(vertex_of(mesh, vertex));
    }
}

/// Calls write(corners), three indices from `first` on.
template <class Write>
void for_triangles(const WeldedMesh& mesh, const Write& write, std::uint32_t first = 0) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        write(std::array{mesh.indices[i] + first, mesh.indices[i + 1] + first, mesh.indices[i + 2] + first});
    }
}

std::uint64_t triangles_of(const WeldedMesh& mesh) {
    return mesh.indices.size() / 3;
}

std::uint64_t save(const std::string& contents, const std::filesystem::path& file) {
    std::ofstream out(file, std::ios::binary | std::ios::trunc);
    out.write(contents.data(), static_cast<std::streamsize>(contents.size())).flush();
    return out ? contents.size() : 0;
}

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

/// Lines "before X Y Z" and "before A B C".
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
    text << "OFF\n" << mesh.vertices << " " << triangles_of(mesh) << " 0\n";
    put_lines(text, mesh, "", "3 ", 0);
    return save(text.all(), file);
}

Text ply_header(const WeldedMesh& mesh, std::string_view encoding) {
    Text text;
    text << "ply\nformat " << encoding << " 1.0\nelement vertex " << mesh.vertices
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
    text << "# vtk DataFile Version 4.2\nmesh\nASCII\nDATASET POLYDATA\nPOINTS " << mesh.vertices << " float\n";
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
    text << "# vtk DataFile Version " << version << "\nmesh\nBINARY\nDATASET POLYDATA\nPOINTS " << mesh.vertices
         << " float\n";
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        for (const float coordinate : xyz) {
            text.bytes(coordinate, std::endian::big);
        }
    });
}

/// Each cell's corners behind their number.
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

/// Offsets, and then all corners.
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

// --- VTP

/// Four letters for three bytes.
void put_base64(Text& text, std::string_view bytes) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        }
        std::array<char, 4> quad{'=', '=', '=', '='};
        for (std::size_t k = 0; k <= count; ++k) {
            quad[k] = letters[bits >> (18 - 6 * k) & 63];
        }
        text << std::string_view(quad.data(), quad.size());
    }
}

/// An array of a VTP file: its numbers as words and as bytes.
struct Numbers {
    std::string_view attributes;
    Text words;
    Text bytes;
};

Numbers points_of(const WeldedMesh& mesh) {
    Numbers numbers{R"(type="Float32" Name="Points" NumberOfComponents="3")", {}, {}};
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        numbers.words << "\n          " << xyz[0] << " " << xyz[1] << " " << xyz[2];
        numbers.bytes.bytes(xyz[0]).bytes(xyz[1]).bytes(xyz[2]);
    });
    return numbers;
}

Numbers connectivity_of(const WeldedMesh& mesh) {
    Numbers numbers{R"(type="Int64" Name="connectivity")", {}, {}};
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        numbers.words << "\n          " << corners[0] << " " << corners[1] << " " << corners[2];
        for (const std::uint32_t corner : corners) {
            numbers.bytes.bytes(std::uint64_t{corner});
        }
    });
    return numbers;
}

Numbers offsets_of(const WeldedMesh& mesh) {
    Numbers numbers{R"(type="Int64" Name="offsets")", {}, {}};
    for (std::uint64_t end = 3; end <= mesh.indices.size(); end += 3) {
        numbers.words << (end % 18 == 3 ? "\n          " : " ") << end;
        numbers.bytes.bytes(end);
    }
    return numbers;
}

/// A file whose arrays are as put(numbers, document, appended) writes them, from their tag's format on.
template <class Put>
std::uint64_t write_vtp(const WeldedMesh& mesh, const std::filesystem::path& file, std::string_view file_attributes,
                        std::string_view appended_encoding, const Put& put) {
    Text document;
    Text appended;
    std::uint64_t unpacked = 0;
    const auto put_array = [&](const Numbers& numbers) {
        document << "        <DataArray " << numbers.attributes << " ";
        put(numbers, document, appended);
        document << "\n        </DataArray>\n";
        unpacked += numbers.bytes.all().size();
    };
    document << R"(<?xml version="1.0"?><VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" )"
             << R"(header_type="UInt64")" << file_attributes << ">\n  <PolyData>\n    <Piece NumberOfPoints=\""
             << mesh.vertices << "\" NumberOfPolys=\"" << triangles_of(mesh) << "\">\n      <Points>\n";
    put_array(points_of(mesh));
    document << "      </Points>\n      <Polys>\n";
    put_array(connectivity_of(mesh));
    put_array(offsets_of(mesh));
    document << "      </Polys>\n    </Piece>\n  </PolyData>\n";
    if (!appended_encoding.empty()) {
        document << "  <AppendedData encoding=\"" << appended_encoding << "\">\n   _" << appended.all()
                 << "\n  </AppendedData>\n";
    }
    document << "</VTKFile>\n";
    return save(document.all(), file) != 0 ? unpacked : 0;
}

std::uint64_t write_vtp_ascii(const WeldedMesh& mesh, const std::filesystem::path& file) {
    return write_vtp(mesh, file, "", "", [](const Numbers& numbers, Text& document, Text& /*appended*/) {
        document << "format=\"ascii\">" << numbers.words.all();
    });
}

std::uint64_t write_vtp_base64(const WeldedMesh& mesh, const std::filesystem::path& file) {
    return write_vtp(mesh, file, "", "", [](const Numbers& numbers, Text& document, Text& /*appended*/) {
        Text bytes;
        bytes.bytes(std::uint64_t{numbers.bytes.all().size()}) << numbers.bytes.all();
        document << "format=\"binary\">\n          ";
        put_base64(document, bytes.all());
    });
}

std::uint64_t write_vtp_raw(const WeldedMesh& mesh, const std::filesystem::path& file) {
    return write_vtp(mesh, file, "", "raw", [](const Numbers& numbers, Text& document, Text& appended) {
        document << "format=\"appended\" offset=\"" << appended.all().size() << "\">";
        appended.bytes(std::uint64_t{numbers.bytes.all().size()}) << numbers.bytes.all();
    });
}

/// In blocks of 32 KiB, as VTK writes them when it is asked for nothing else.
void put_zlib(const std::string& bytes, Text& appended) {
    constexpr std::size_t block_bytes = std::size_t{32} << 10;
    const std::size_t blocks = (bytes.size() + block_bytes - 1) / block_bytes;
    Text header;
    Text packed;
    header.bytes(std::uint64_t{blocks}).bytes(std::uint64_t{block_bytes}).bytes(std::uint64_t{bytes.size() % block_bytes});
    std::string room(compressBound(block_bytes), '\0');
    for (std::size_t begin = 0; begin < bytes.size(); begin += block_bytes) {
        uLongf size = room.size();
        compress2(reinterpret_cast<Bytef*>(room.data()), &size, reinterpret_cast<const Bytef*>(bytes.data() + begin),
                  std::min(block_bytes, bytes.size() - begin), 5);
        header.bytes(std::uint64_t{size});
        packed << std::string_view(room).substr(0, size);
    }
    put_base64(appended, header.all());
    put_base64(appended, packed.all());
}

std::uint64_t write_vtp_zlib(const WeldedMesh& mesh, const std::filesystem::path& file) {
    return write_vtp(mesh, file, R"( compressor="vtkZLibDataCompressor")", "base64",
                     [](const Numbers& numbers, Text& document, Text& appended) {
                         document << "format=\"appended\" offset=\"" << appended.all().size() << "\">";
                         put_zlib(numbers.bytes.all(), appended);
                     });
}

// --- 3MF

std::string model_part(const WeldedMesh& mesh) {
    Text text;
    text << R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
 <resources>
  <object id="1" type="model">
   <mesh>
    <vertices>
)";
    for_vertices(mesh, [&](const std::array<float, 3>& xyz) {
        text << "     <vertex x=\"" << xyz[0] << "\" y=\"" << xyz[1] << "\" z=\"" << xyz[2] << "\"/>\n";
    });
    text << "    </vertices>\n    <triangles>\n";
    for_triangles(mesh, [&](const std::array<std::uint32_t, 3>& corners) {
        text << "     <triangle v1=\"" << corners[0] << "\" v2=\"" << corners[1] << "\" v3=\"" << corners[2] << "\"/>\n";
    });
    text << "    </triangles>\n   </mesh>\n  </object>\n </resources>\n <build>\n  <item objectid=\"1\"/>\n </build>\n"
         << "</model>\n";
    return text.all();
}

bool add_part(zipFile zip, const char* name, const std::string& contents) {
    return zipOpenNewFileInZip(zip, name, nullptr, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED, 6) == ZIP_OK &&
           zipWriteInFileInZip(zip, contents.data(), static_cast<unsigned>(contents.size())) == ZIP_OK &&
           zipCloseFileInZip(zip) == ZIP_OK;
}

std::uint64_t write_3mf(const WeldedMesh& mesh, const std::filesystem::path& file) {
    const std::string types =
        R"(<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">)"
        R"(<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)";
    const std::string relationships =
        R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
        R"(<Relationship Target="/3D/3dmodel.model" Id="rel0")"
        R"( Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";
    zipFile zip = zipOpen64(file.c_str(), APPEND_STATUS_CREATE);
    if (zip == nullptr) {
        return 0;
    }
    const std::string model = model_part(mesh);
    const bool added = add_part(zip, "[Content_Types].xml", types) && add_part(zip, "_rels/.rels", relationships) &&
                       add_part(zip, "3D/3dmodel.model", model);
    return zipClose(zip, nullptr) == ZIP_OK && added ? model.size() : 0;
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
