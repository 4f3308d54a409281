// STL, binary and ASCII. Which of the two a file is, is decided by its size and content, never by the word "solid" alone.

#include "base/words.hpp"
#include "io/read/stated.hpp"

namespace lamella {

namespace {

// A binary file: 80 bytes of anything, the number of triangles, and for each 12 floats (normal, three vertices) and 16 bits.
//
//     | header 80 | count 4 | normal 12 | vertices 36 | attribute 2 | normal ...
//     0           80        84          96            132           134
constexpr std::size_t header_bytes = 84;
constexpr std::uint64_t record_bytes = 50;  // times a count, in 64 bits everywhere
constexpr std::size_t normal_bytes = 12;

bool begins_with_solid(std::string_view text) {
    text = without_byte_order_mark(text);
    text.remove_prefix(static_cast<std::size_t>(skip_space(text.begin(), text.end()) - text.begin()));
    return begins_in_any_case(text, "solid");
}

/// The number of triangles, if the file holds as many as it says.
Result<std::uint64_t> check_binary(const FileSource& file) {
    if (file.size() < header_bytes) {
        return file.error(ErrorCode::malformed_mesh,
                          "is no STL file: " + counted(file.size(), "byte") + ", and a binary header alone has 84", 0);
    }
    std::uint32_t count = 0;
    std::memcpy(&count, file.sample().data() + header_bytes - sizeof count, sizeof count);
    const std::uint64_t needed = header_bytes + record_bytes * count;
    if (count == 0 && file.size() == header_bytes) {
        return file.error(ErrorCode::empty_mesh, "holds no triangles");
    }
    if (count == 0 || needed > file.size()) {
        return file.error(ErrorCode::malformed_mesh,
                          "is truncated or no STL file: counts " + counted(count, "triangle") + " at byte 80, which " +
                              (count == 1 ? "takes " : "take ") + std::to_string(needed) + " bytes, but has " +
                              std::to_string(file.size()),
                          80);
    }
    return count;
}

/// True if what is no text would be, were it not for NUL bytes, and holds a facet.
bool is_ascii_with_nuls(const FileSource& file) {
    const std::string_view sample = file.sample();
    if (!begins_with_solid(sample) || check_binary(file)) {
        return false;
    }
    const bool others = std::any_of(sample.begin(), sample.end(), [](char c) { return c > 0 && c < ' ' && !is_space(c); });
    constexpr std::string_view facet = "facet";
    return !others && std::search(sample.begin(), sample.end(), facet.begin(), facet.end(),
                                  [](char a, char b) { return lower_case(a) == b; }) != sample.end();
}

}  // namespace

bool looks_like_stl(const FileSource& source) {
    return is_text(source.sample()) ? begins_with_solid(source.sample())
                                    : check_binary(source).ok() || is_ascii_with_nuls(source);
}

void check_stl(const FileSource& source) {
    if (!is_text(source.sample()) && !is_ascii_with_nuls(source)) {
        (void)require(check_binary(source));
    }
}

void parse_stl(FileContents& file, MeshFile& mesh) {
    if (is_text(file.source.sample()) || is_ascii_with_nuls(file.source)) {
        return parse_ascii_stl(file, mesh);
    }
    mesh = describe_binary_stl(file.source);
    mesh.bytes = std::move(file.bytes);
    mesh.bytes.set_size(header_bytes + record_bytes * mesh.triangle_count);
}

bool is_binary_stl(const FileSource& source) {
    return !is_text(source.sample()) && check_binary(source).ok();
}

MeshFile describe_binary_stl(const FileSource& file) {
    const std::uint64_t count = require(check_binary(file));
    const std::uint64_t needed = header_bytes + record_bytes * count;
    MeshFile mesh;
    mesh.first_offset = header_bytes + normal_bytes;
    mesh.stride = std::size_t{record_bytes};
    mesh.triangle_count = count;
    give_stated_frame(file.sample().substr(0, 80), file, mesh);
    if (file.size() > needed) {
        mesh.warnings.push_back(file.name() + ": ignored " + counted(file.size() - needed, "byte") + " after the last of " +
                                counted(count, "triangle"));
    }
    return mesh;
}

}  // namespace lamella
