// Zip archives and 3MF packages for the tests of the readers, whole or spoilt.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "files.hpp"

namespace lamella::input_test {

/// A part of an archive, and what its headers say of it where that is not the truth.
struct ZipPart {
    std::string name;
    std::string contents;
    bool deflated = true;
    std::uint16_t flags = 0;
    std::uint16_t method = 0xFFFF;   ///< 0xFFFF: as it is
    std::uint32_t false_crc = 0;     ///< added to the checksum
    std::uint32_t excess_bytes = 0;  ///< added to the expanded size
};

inline std::string little_endian16(std::uint16_t value) {
    return little_endian(value).substr(0, 2);
}

inline std::string zip(const std::vector<ZipPart>& parts) {
    std::string archive;
    std::string directory;
    for (const ZipPart& part : parts) {
        const std::string packed = part.deflated ? deflated(part.contents) : part.contents;
        const auto crc = static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(part.contents.data()), static_cast<uInt>(part.contents.size())));
        const std::uint16_t method = part.method != 0xFFFF ? part.method : (part.deflated ? 8 : 0);
        // What the local header and the directory have in common, from the version on.
        const std::string fields = little_endian16(20) + little_endian16(part.flags) + little_endian16(method) +
                                   little_endian(0x21 << 16) + little_endian(crc + part.false_crc) +
                                   little_endian(static_cast<std::uint32_t>(packed.size())) +
                                   little_endian(static_cast<std::uint32_t>(part.contents.size()) + part.excess_bytes) +
                                   little_endian16(static_cast<std::uint16_t>(part.name.size())) + little_endian16(0);
        directory += "PK\1\2" + little_endian16(20) + fields + std::string(10, '\0') +
                     little_endian(static_cast<std::uint32_t>(archive.size())) + part.name;
        archive += "PK\3\4" + fields + part.name + packed;
    }
    const std::string count = little_endian16(static_cast<std::uint16_t>(parts.size()));
    return archive + directory + "PK\5\6" + std::string(4, '\0') + count + count +
           little_endian(static_cast<std::uint32_t>(directory.size())) +
           little_endian(static_cast<std::uint32_t>(archive.size())) + little_endian16(0);
}

inline const std::string core_space = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
inline const std::string production_space = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

inline ZipPart content_types() {
    return {"[Content_Types].xml",
            R"(<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">)"
            R"(<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>)"
            R"(<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)"};
}

inline ZipPart relationships(const std::string& target = "/3D/3dmodel.model", const std::string& more = "") {
    return {"_rels/.rels",
            R"(<?xml version="1.0"?><Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">)"
            R"(<Relationship Target="/thumbnail.png" Id="rel0" Type="http://example.org/thumbnail"/>)"
            R"(<Relationship Target=")" +
                target + R"(" Id="rel1" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>)" + more +
                "</Relationships>"};
}

/// A package whose root part is `model`, with `others` beside it.
inline std::string package(const std::string& model, std::vector<ZipPart> others = {}) {
    std::vector<ZipPart> parts = {content_types(), relationships(), {"3D/3dmodel.model", model}};
    parts.insert(parts.end(), others.begin(), others.end());
    return zip(parts);
}

inline std::string model_text(const std::string& resources, const std::string& items, const std::string& attributes = "") {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model xmlns=\"" + core_space + "\" xmlns:p=\"" + production_space +
           "\" " + attributes + ">\n<resources>\n" + resources + "</resources>\n<build>\n" + items + "</build>\n</model>\n";
}

/// A cube of edge 10 between the origin and (10, 10, 10), counter-clockwise as seen from outside.
inline const std::vector<std::array<int, 3>> cube_triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7},
                                                               {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5},
                                                               {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
inline const std::vector<std::array<int, 3>> cube_vertices = {{0, 0, 0},  {10, 0, 0},  {10, 10, 0},  {0, 10, 0},
                                                              {0, 0, 10}, {10, 0, 10}, {10, 10, 10}, {0, 10, 10}};

inline std::string cube_mesh() {
    std::string text = "<mesh><vertices>\n";
    for (const auto& v : cube_vertices) {
        text += "<vertex x=\"" + std::to_string(v[0]) + "\" y=\"" + std::to_string(v[1]) + "\" z=\"" + std::to_string(v[2]) +
                "\"/>\n";
    }
    text += "</vertices><triangles>\n";
    for (const auto& t : cube_triangles) {
        text += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" +
                std::to_string(t[2]) + "\"/>\n";
    }
    return text + "</triangles></mesh>";
}

inline std::string object(int id, const std::string& contents, const std::string& attributes = "") {
    return "<object id=\"" + std::to_string(id) + "\" " + attributes + ">" + contents + "</object>\n";
}

inline std::string item(int id, const std::string& attributes = "") {
    return "<item objectid=\"" + std::to_string(id) + "\" " + attributes + "/>\n";
}

inline std::string components(const std::vector<std::string>& list) {
    std::string text = "<components>";
    for (const std::string& component : list) {
        text += "<component " + component + "/>";
    }
    return text + "</components>";
}

}  // namespace lamella::input_test
