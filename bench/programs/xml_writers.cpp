#include "xml_writers.hpp"

#include <zip.h>
#include <zlib.h>

#include "written_text.hpp"

namespace lamella::bench {

namespace {

/// Base64: four letters for three bytes.
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

/// A file whose arrays are written by put(numbers, document, appended), from the format in their tag on.
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
             << mesh.vertex_count << "\" NumberOfPolys=\"" << triangles_of(mesh) << "\">\n      <Points>\n";
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

/// zlib blocks of 32 KiB, VTK's default.
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

/// `contents` must outlive the archive.
bool add_part(zip_t* zip, const char* name, const std::string& contents) {
    zip_source_t* const source = zip_source_buffer(zip, contents.data(), contents.size(), 0);
    const zip_int64_t part = source == nullptr ? -1 : zip_file_add(zip, name, source, 0);
    if (part < 0) {
        zip_source_free(source);
        return false;
    }
    return zip_set_file_compression(zip, static_cast<zip_uint64_t>(part), ZIP_CM_DEFLATE, 6) == 0;
}

}  // namespace

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

std::uint64_t write_vtp_zlib(const WeldedMesh& mesh, const std::filesystem::path& file) {
    return write_vtp(mesh, file, R"( compressor="vtkZLibDataCompressor")", "base64",
                     [](const Numbers& numbers, Text& document, Text& appended) {
                         document << "format=\"appended\" offset=\"" << appended.all().size() << "\">";
                         put_zlib(numbers.bytes.all(), appended);
                     });
}

std::uint64_t write_3mf(const WeldedMesh& mesh, const std::filesystem::path& file) {
    const std::string types =
        R"(<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">)"
        R"(<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)";
    const std::string relationships =
        R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
        R"(<Relationship Target="/3D/3dmodel.model" Id="rel0")"
        R"( Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";
    zip_t* const zip = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    if (zip == nullptr) {
        return 0;
    }
    const std::string model = model_part(mesh);
    const bool added = add_part(zip, "[Content_Types].xml", types) && add_part(zip, "_rels/.rels", relationships) &&
                       add_part(zip, "3D/3dmodel.model", model);
    return zip_close(zip) == 0 && added ? model.size() : 0;
}

}  // namespace lamella::bench
