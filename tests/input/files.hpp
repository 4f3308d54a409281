// Files for the tests of the readers: STL in both forms, and what is done to the bytes of files.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include <zlib.h>

#include <catch2/catch.hpp>

#include "engine/shapes.hpp"
#include "temp_folder.hpp"

namespace lamella::input_test {

using shapes::Soup;

/// Facets that tell which one they are.
inline Soup numbered_facets(std::size_t count) {
    Soup facets;
    for (std::size_t i = 0; i < count; ++i) {
        const auto x = static_cast<double>(i);
        facets.insert(facets.end(), {x, 0, 0, x + 1, 0, 0.5, x, 1, -0.25});
    }
    return facets;
}

template <class Number>
std::string bytes_of(Number value, bool big_endian = false) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    if (big_endian != (std::endian::native == std::endian::big)) {
        std::reverse(bytes.begin(), bytes.end());
    }
    return bytes;
}

/// What a binary STL file holds beside its facets.
struct StlForm {
    std::string header{};
    std::int64_t counted = -1;  ///< what the header says; -1: the truth
    char normal = '\x7f';       ///< of which all normals are made
    std::string attribute = std::string(2, '\0');
};

inline std::string binary_stl(const Soup& soup, const StlForm& form = {}) {
    const std::size_t count = soup.size() / 9;
    std::string bytes = form.header;
    bytes.resize(80, '\0');
    bytes += bytes_of(static_cast<std::uint32_t>(form.counted < 0 ? static_cast<std::int64_t>(count) : form.counted));
    for (std::size_t i = 0; i < soup.size(); ++i) {
        bytes.append(i % 9 == 0 ? 12 : 0, form.normal).append(bytes_of(static_cast<float>(soup[i])));
        bytes += i % 9 == 8 ? form.attribute : "";
    }
    return bytes;
}

inline std::string text_stl(const Soup& soup, const std::string& name = "part") {
    std::string text = "solid " + name + "\n";
    for (std::size_t i = 0; i < soup.size(); ++i) {
        text += i % 9 == 0 ? "facet normal 0 0 1\n outer loop\n" : "";
        text += (i % 3 == 0 ? "  vertex " : " ") + std::to_string(soup[i]) + (i % 3 == 2 ? "\n" : "");
        text += i % 9 == 8 ? " endloop\nendfacet\n" : "";
    }
    return text + "endsolid " + name + "\n";
}

/// `bytes` deflated; `window_bits` as zlib takes them: -MAX_WBITS for the bare data, 16 + MAX_WBITS for gzip.
inline std::string deflated(const std::string& bytes, int window_bits = -MAX_WBITS) {
    std::string packed(bytes.size() + bytes.size() / 100 + 1024, '\0');
    z_stream stream{};
    REQUIRE(deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) == Z_OK);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    REQUIRE(deflate(&stream, Z_FINISH) == Z_STREAM_END);
    packed.resize(packed.size() - stream.avail_out);
    deflateEnd(&stream);
    return packed;
}

inline std::string gzipped(const std::string& bytes) {
    return deflated(bytes, 16 + MAX_WBITS);
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

}  // namespace lamella::input_test
