// Files for the tests of the readers: folders and STL in both forms.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
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

/// What use(number) makes of `value` as the type of that name in PLY, legacy VTK or VTP; 64-bit integers where there is
/// none. What an integer does not hold wraps round.
template <class Number, class Use>
auto as_type(std::string_view type, Number value, const Use& use) {
    const auto is = [type](const std::string& names) { return names.find(" " + std::string(type) + " ") != names.npos; };
    const auto whole = [value] { return static_cast<std::int64_t>(value); };
    return is(" float float32 Float32 ")                 ? use(static_cast<float>(value))
           : is(" double float64 Float64 ")              ? use(static_cast<double>(value))
           : is(" uchar uint8 unsigned_char UInt8 ")     ? use(static_cast<std::uint8_t>(whole()))
           : is(" char int8 Int8 ")                      ? use(static_cast<std::int8_t>(whole()))
           : is(" ushort uint16 unsigned_short UInt16 ") ? use(static_cast<std::uint16_t>(whole()))
           : is(" short int16 Int16 ")                   ? use(static_cast<std::int16_t>(whole()))
           : is(" uint uint32 unsigned_int UInt32 ")     ? use(static_cast<std::uint32_t>(whole()))
           : is(" int int32 Int32 vtktypeint32 ")        ? use(static_cast<std::int32_t>(whole()))
           : is(" unsigned_long UInt64 ")                ? use(static_cast<std::uint64_t>(value))
                                                         : use(whole());
}

template <class Number>
std::string bytes_of(Number value, bool big_endian) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    if (big_endian != (std::endian::native == std::endian::big)) {
        std::reverse(bytes.begin(), bytes.end());
    }
    return bytes;
}

inline std::string little_endian(std::uint32_t value) {
    return bytes_of(value, false);
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

inline std::string replaced(const std::string& text, const std::string& what, const std::string& by) {
    std::string made;
    std::size_t begin = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, begin)) {
        made.append(text, begin, at - begin).append(by);
        begin = at + what.size();
    }
    return made.append(text, begin);
}

inline std::string repeated(const std::string& text, std::size_t count) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) {
        all += text;
    }
    return all;
}

/// Of ASCII letters.
inline std::string upper(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c; });
    return text;
}

}  // namespace lamella::input_test
