// VTK's XML files of polygonal data, with their arrays stored in every way.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "vtk_files.hpp"

namespace lamella::vtk_test {

inline std::string base64(const std::string& bytes) {
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : alphabet[bits >> (18 - 6 * k) & 63];
        }
    }
    return text;
}

/// Writes files whose arrays are all stored in one way.
struct Xml {
    std::string format = "ascii";  ///< or "binary", or "raw" or "base64" for those that are appended
    bool zlib = false;
    bool big_endian = false;
    bool wide = true;  ///< headers of 64 bits
    std::string points = "Float32";
    std::string integers = "Int64";
    std::size_t block = 64;
    std::string field{};     ///< before the pieces
    std::string appended{};  ///< what has been appended so far

    bool text() const { return format == "ascii"; }

    std::string header(const std::vector<std::uint64_t>& numbers) const {
        std::string bytes;
        for (const std::uint64_t number : numbers) {
            bytes += Encoding{false, big_endian}.as(wide ? "UInt64" : "UInt32", number);
        }
        return bytes;
    }

    std::string stored(const std::string& data) const {
        std::string head;
        std::string body = data;
        if (zlib) {
            std::vector<std::uint64_t> counts{(data.size() + block - 1) / block, block, data.size() % block};
            body.clear();
            for (std::size_t at = 0; at < data.size(); at += block) {
                const std::string packed = deflated(data.substr(at, block), MAX_WBITS);
                counts.push_back(packed.size());
                body += packed;
            }
            head = header(counts);
            return format == "raw" ? head + body : base64(head) + base64(body);
        }
        head = header({data.size()});
        return format == "raw" ? head + body : base64(head + body);
    }

    std::string element(const std::string& attributes, const std::string& data) {
        std::string start = "<DataArray " + attributes + " format=\"";
        if (text() || format == "binary") {
            return start + format + "\">\n" + (text() ? data : stored(data)) + "\n</DataArray>\n";
        }
        start += "appended\" offset=\"" + std::to_string(appended.size()) + "\"><InformationKey name=\"a\"/></DataArray>\n";
        appended += stored(data);
        return start;
    }

    std::string array(const std::string& name, const std::string& type, const std::vector<double>& values) {
        std::string data;
        for (const double value : values) {
            data += Encoding{text(), big_endian}.as(type, value);
        }
        return element("type=\"" + type + "\" Name=\"" + name + "\"" + (name == "Points" ? " NumberOfComponents=\"3\"" : ""),
                       data);
    }

    std::string cells(const std::string& name, const Cells& cells) {
        std::vector<double> offsets;
        std::vector<double> corners;
        for (const auto& cell : cells) {
            corners.insert(corners.end(), cell.begin(), cell.end());
            offsets.push_back(static_cast<double>(corners.size()));
        }
        std::string xml = "<" + name + ">\n" + array("connectivity", integers, corners);
        xml += array("offsets", integers, offsets);
        return xml + "</" + name + ">\n";
    }

    std::string piece(const PolyData& data) {
        std::string xml = "<Piece NumberOfPoints=\"" + std::to_string(data.points.size()) + "\" NumberOfStrips=\"" +
                          std::to_string(data.strips.size()) + "\" NumberOfPolys=\"" + std::to_string(data.polygons.size()) +
                          "\">\n";
        // One by one: each array is appended as it is made.
        xml += "<PointData>" + array("Points", "Float32", {1, 2, 3, 4}) + "</PointData>\n";
        xml += "<Points>" + array("Points", points, data.coordinates()) + "</Points>\n";
        xml += "<Verts>" + array("connectivity", "Int64", {}) + "</Verts>\n";
        xml += cells("Strips", data.strips);
        xml += cells("Polys", data.polygons);
        return xml + "</Piece>\n";
    }

    std::string operator()(const std::vector<PolyData>& pieces) {
        appended.clear();
        std::string file = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"") +
                           (big_endian ? "BigEndian" : "LittleEndian") + "\"" + (wide ? " header_type=\"UInt64\"" : "") +
                           (zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">\n<PolyData>\n" + field;
        for (const PolyData& data : pieces) {
            file += piece(data);
        }
        file += "</PolyData>\n";
        if (format == "raw" || format == "base64") {
            file += "<AppendedData encoding=\"" + format + "\">\n _" + appended + "\n</AppendedData>\n";
        }
        return file + "</VTKFile>\n";
    }
};

}  // namespace lamella::vtk_test
