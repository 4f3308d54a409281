// STL, binary and ASCII. Which of the two a file is, is decided by its size and content, never by the word "solid" alone.
#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "base/clock.hpp"
#include "base/little_endian.hpp"
#include "base/parallel.hpp"
#include "base/words.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/read/stl/facet_parser.hpp"
#include "io/read/stl/stl_ascii.hpp"
#include "io/text/text.hpp"

namespace lamella {

namespace {

// A binary file: 80 bytes of anything, the number of triangles, and for each 12 floats (normal, three vertices) and 16 bits.
//
//     | header 80 | count 4 | normal 12 | vertices 36 | attribute 2 | normal ...
//     0           80        84          96            132           134
constexpr std::size_t header_bytes = 84;
constexpr std::size_t record_bytes = 50;
constexpr std::size_t normal_bytes = 12;

bool begins_with_solid(std::string_view text) {
    text = without_byte_order_mark(text);
    const char* end = text.data() + text.size();
    const char* p = skip_space(text.data(), end);
    constexpr std::string_view solid = "solid";
    return end - p >= static_cast<std::ptrdiff_t>(solid.size()) &&
           std::equal(solid.begin(), solid.end(), p, [](char a, char b) { return a == (b | 0x20); });
}

std::uint32_t counted_triangles(std::string_view sample) {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        count |= static_cast<std::uint32_t>(static_cast<unsigned char>(sample[80 + i])) << (8 * i);
    }
    return count;
}

/// The number of triangles, if the file holds as many as it says.
Result<std::uint64_t> check_binary(const FileSource& file) {
    if (file.size() < header_bytes) {
        return file.error(ErrorCode::malformed_mesh,
                          "is no STL file: " + counted(file.size(), "byte") + ", and a binary header alone has 84", 0);
    }
    const std::uint64_t count = counted_triangles(file.sample());
    const std::uint64_t needed = header_bytes + record_bytes * count;
    if (count == 0 && file.size() == header_bytes) {
        return file.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    if (count == 0) {
        return file.error(ErrorCode::malformed_mesh,
                          "counts 0 triangles at byte 80, but " + counted(file.size() - needed, "byte") +
                              (file.size() - needed == 1 ? " follows" : " follow"),
                          80);
    }
    if (needed > file.size()) {
        return file.error(ErrorCode::malformed_mesh,
                          "is truncated or no STL file: counts " + counted(count, "triangle") + " at byte 80, which " +
                              (count == 1 ? "takes " : "take ") + std::to_string(needed) + " bytes, but has " +
                              std::to_string(file.size()),
                          80);
    }
    return count;
}

Result<MeshFile> read_binary(FileSource& file) {
    const Result<std::uint64_t> count = check_binary(file);
    if (!count) {
        return count.error();
    }
    const std::uint64_t needed = header_bytes + record_bytes * count.value();
    Result<Array<std::byte>> bytes = file.take(needed);
    if (!bytes) {
        return bytes.error();
    }
    MeshFile mesh;
    mesh.bytes = std::move(bytes).value();
    mesh.first_offset = header_bytes + normal_bytes;
    mesh.stride = record_bytes;
    mesh.triangle_count = count.value();
    give_stated_frame(file.sample().substr(0, 80), file, mesh);
    if (file.size() > needed) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(file.size() - needed, "byte") + " after the last of " +
                                counted(count.value(), "triangle"));
    }
    return mesh;
}

Result<MeshFile> read_ascii(FileSource& file) {
    const Result<FileText> contents = file.take_text();
    if (!contents) {
        return contents.error();
    }
    const std::string_view whole = contents->whole;
    const std::string_view text = contents->text;
    AsciiFacets facets = parse_ascii_stl(text, file.memory(), file.parallel());
    if (facets.error) {
        return file.error_in_text(whole, facets.error->offset + (whole.size() - text.size()), facets.error->what);
    }
    if (facets.count == 0) {
        return file.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    MeshFile mesh;
    mesh.bytes = std::move(facets.coordinates);
    mesh.stride = 9 * sizeof(float);
    mesh.triangle_count = facets.count;
    mesh.text = true;
    give_stated_frame(text.substr(0, text.find_first_of("\r\n")), file, mesh);
    if (facets.open_end) {
        mesh.warnings.push_back(file.name() + ": ends without 'endsolid' after line " +
                                std::to_string(line_of(text, *facets.open_end)) + ": what follows may have been cut off");
    }
    mesh.parse_ms = milliseconds_since(contents->taken);
    return mesh;
}

}  // namespace

bool looks_like_stl(const FileSource& source) {
    return is_text(source.sample()) ? begins_with_solid(source.sample()) : check_binary(source).ok();
}

Result<MeshFile> read_stl(FileSource& source) {
    return is_text(source.sample()) ? read_ascii(source) : read_binary(source);
}

}  // namespace lamella
