// Files for the tests of the readers: folders and STL in both forms.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

#include <catch2/catch.hpp>

#include "temp_folder.hpp"

namespace lamella::input_test {

/// Nine coordinates.
using Facet = std::array<float, 9>;

/// A facet that tells which one it is.
inline Facet numbered_facet(std::size_t i) {
    const auto x = static_cast<float>(i);
    return {x, 0, 0, x + 1, 0, 0.5F, x, 1, -0.25F};
}

inline std::vector<Facet> numbered_facets(std::size_t count) {
    std::vector<Facet> facets;
    for (std::size_t i = 0; i < count; ++i) {
        facets.push_back(numbered_facet(i));
    }
    return facets;
}

inline std::string little_endian(std::uint32_t value) {
    std::string bytes;
    for (int shift = 0; shift < 32; shift += 8) {
        bytes += static_cast<char>(value >> shift & 0xFF);
    }
    return bytes;
}

/// `counted` is what the header says.
inline std::string binary_stl(const std::vector<Facet>& facets, std::uint32_t counted, std::string header = "",
                              const std::string& attribute = std::string(2, '\0')) {
    header.resize(80, '\0');
    std::string bytes = header + little_endian(counted);
    for (const Facet& facet : facets) {
        std::string corners(sizeof facet, '\0');
        std::memcpy(corners.data(), facet.data(), sizeof facet);
        bytes.append(12, '\x7f').append(corners).append(attribute);
    }
    return bytes;
}

inline std::string binary_stl(const std::vector<Facet>& facets) {
    return binary_stl(facets, static_cast<std::uint32_t>(facets.size()));
}

inline std::string ascii_facet(const Facet& f, const std::string& normal = "0 0 1") {
    std::string text = "  facet normal " + normal + "\n    outer loop\n";
    for (std::size_t corner = 0; corner < 3; ++corner) {
        text += "      vertex";
        for (std::size_t axis = 0; axis < 3; ++axis) {
            text += " " + std::to_string(f[3 * corner + axis]);
        }
        text += "\n";
    }
    return text + "    endloop\n  endfacet\n";
}

inline std::string ascii_stl(const std::vector<Facet>& facets, const std::string& name = "part") {
    std::string text = "solid " + name + "\n";
    for (const Facet& facet : facets) {
        text += ascii_facet(facet);
    }
    return text + "endsolid " + name + "\n";
}

/// `bytes` deflated; `window_bits` as zlib takes them: -MAX_WBITS for the bare data, 16 + MAX_WBITS for gzip.
inline std::string deflated(const std::string& bytes, int window_bits = -MAX_WBITS) {
    std::string packed(bytes.size() + bytes.size() / 100 + 1024, '\0');
    z_stream stream{};
    REQUIRE(deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
    packed.resize(packed.size() - stream.avail_out);
    deflateEnd(&stream);
    return packed;
}

inline std::string replaced(std::string text, const std::string& what, const std::string& by) {
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
        text.replace(at, what.size(), by);
    }
    return text;
}

/// Of ASCII letters.
inline std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
    return text;
}

}  // namespace lamella::input_test
