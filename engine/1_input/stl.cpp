#include "lamella/stl.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <string_view>
#include <utility>

#include "1_input/facet_parser.hpp"
#include "1_input/input_file.hpp"
#include "1_input/stl_ascii.hpp"
#include "base/parallel.hpp"

namespace lamella {

namespace {

// A binary file: 80 bytes of anything, the number of triangles, and for each 12 floats (normal, three vertices) and 16 bits.
//
//     | header 80 | count 4 | normal 12 | vertices 36 | attribute 2 | normal ...
//     0           80        84          96            132           134
constexpr std::size_t header_bytes = 84;
constexpr std::size_t record_bytes = 50;
constexpr std::size_t normal_bytes = 12;
static_assert(std::endian::native == std::endian::little, "the file's numbers are used where they lie");

/// How much of the file decides what it is.
constexpr std::size_t sample_bytes = std::size_t{64} << 10;

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string_view without_byte_order_mark(std::string_view text) {
    return text.substr(text.starts_with("\xEF\xBB\xBF") ? 3 : 0);
}

/// No control characters. Every binary file has some: its count has a zero byte below 2^24 triangles, and beyond, a sample
/// of a thousand records has plenty.
bool is_text(std::string_view sample) {
    return std::none_of(sample.begin(), sample.end(), [](char c) { return c >= 0 && c < ' ' && !is_space(c); });
}

bool begins_with_solid(std::string_view text) {
    text = without_byte_order_mark(text);
    const char* end = text.data() + text.size();
    const char* p = skip_space(text.data(), end);
    constexpr std::string_view solid = "solid";
    return end - p >= static_cast<std::ptrdiff_t>(solid.size()) &&
           std::equal(solid.begin(), solid.end(), p, [](char a, char b) { return a == (b | 0x20); });
}

Error no_text_stl(const InputFile& file, std::string_view sample) {
    constexpr std::size_t quoted = 32;
    const std::string_view line = sample.substr(0, std::min(sample.find_first_of("\r\n"), quoted));
    return file.error(Code::malformed_mesh, "is no STL file: text that begins with '" + printable(std::string(line)) + "'",
                      0);
}

std::uint32_t counted_triangles(std::string_view sample) {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        count |= static_cast<std::uint32_t>(static_cast<unsigned char>(sample[80 + i])) << (8 * i);
    }
    return count;
}

/// The number of triangles, if the file holds as many as it says.
Result<std::uint64_t> check_binary(const InputFile& file, std::string_view sample) {
    if (file.size() < header_bytes) {
        return file.error(Code::malformed_mesh,
                          "is no STL file: " + std::to_string(file.size()) + " bytes, and a binary header alone has 84", 0);
    }
    const std::uint64_t count = counted_triangles(sample);
    const std::uint64_t needed = header_bytes + record_bytes * count;
    if (count == 0 && file.size() == header_bytes) {
        return file.error(Code::empty_mesh, "holds no triangles");
    }
    if (count == 0) {
        return file.error(Code::malformed_mesh,
                          "counts 0 triangles at byte 80, but " + std::to_string(file.size() - needed) + " bytes follow",
                          80);
    }
    if (needed > file.size()) {
        return file.error(Code::malformed_mesh,
                          "is truncated or no STL file: counts " + std::to_string(count) +
                              " triangles at byte 80, which take " + std::to_string(needed) + " bytes, but has " +
                              std::to_string(file.size()),
                          80);
    }
    return count;
}

Result<Array<std::byte>> get_bytes(const InputFile& file, std::size_t count, const StlReadOptions& options,
                                   const Parallel& parallel) {
    if (options.map_file) {
        Result<Array<std::byte>> mapped = file.map(count);
        if (!mapped) {
            return mapped;
        }
        if (Status same = file.unchanged(); !same) {
            return same.error();
        }
        return mapped;
    }
    Array<std::byte> bytes(options.memory);
    bytes.resize_discarding(count);
    if (Status got = file.read(bytes.span(), parallel); !got) {
        return got.error();
    }
    if (Status same = file.unchanged(); !same) {
        return same.error();
    }
    return bytes;
}

Result<StlMesh> read_binary(const InputFile& file, std::string_view sample, const StlReadOptions& options,
                            const Parallel& parallel) {
    const Result<std::uint64_t> count = check_binary(file, sample);
    if (!count) {
        return count.error();
    }
    const std::uint64_t needed = header_bytes + record_bytes * count.value();
    Result<Array<std::byte>> bytes = get_bytes(file, needed, options, parallel);
    if (!bytes) {
        return bytes.error();
    }
    StlMesh mesh;
    mesh.bytes = std::move(bytes).value();
    mesh.first_offset = header_bytes + normal_bytes;
    mesh.stride = record_bytes;
    mesh.triangle_count = count.value();
    if (file.size() > needed) {
        mesh.warnings.push_back(file.name() + ": ignored " + std::to_string(file.size() - needed) +
                                " bytes after the last of " + std::to_string(count.value()) + " triangles");
    }
    return mesh;
}

Result<StlMesh> read_ascii(const InputFile& file, const StlReadOptions& options, const Parallel& parallel) {
    const Result<Array<std::byte>> bytes = get_bytes(file, file.size(), options, parallel);
    if (!bytes) {
        return bytes.error();
    }
    const Clock::time_point start = Clock::now();
    const std::string_view text = without_byte_order_mark(as_text(bytes.value().span()));
    AsciiFacets facets = parse_ascii_stl(text, options.memory, parallel);
    if (facets.error) {
        const std::size_t offset = facets.error->offset + (file.size() - text.size());
        return file.error(
            Code::malformed_mesh,
            "line " + std::to_string(facets.error->line) + ", byte " + std::to_string(offset) + ": " + facets.error->what,
            static_cast<std::int64_t>(offset));
    }
    if (facets.count == 0) {
        return file.error(Code::empty_mesh, "holds no triangles");
    }
    StlMesh mesh;
    mesh.bytes = std::move(facets.coordinates);
    mesh.stride = 9 * sizeof(float);
    mesh.triangle_count = facets.count;
    mesh.ascii = true;
    mesh.parse_ms = ms_since(start);
    return mesh;
}

Result<StlMesh> read(const std::filesystem::path& path, const StlReadOptions& options) {
    const Clock::time_point start = Clock::now();
    const Result<InputFile> opened = InputFile::open(path);
    if (!opened) {
        return opened.error();
    }
    const InputFile& file = opened.value();
    if (file.size() == 0) {
        return file.error(Code::empty_mesh, "is empty");
    }
    const Parallel parallel(options.threads);
    std::vector<std::byte> sampled(std::min<std::uint64_t>(file.size(), sample_bytes));
    if (Status got = file.read(sampled, parallel); !got) {
        return got.error();
    }
    const std::string_view sample = as_text(sampled);
    const bool text = is_text(sample);
    if (text && !begins_with_solid(sample)) {
        return no_text_stl(file, sample);
    }
    Result<StlMesh> mesh = text ? read_ascii(file, options, parallel) : read_binary(file, sample, options, parallel);
    if (mesh) {
        mesh->file_bytes = file.size();
        mesh->read_ms = ms_since(start) - mesh->parse_ms;
    }
    return mesh;
}

}  // namespace

Result<StlMesh> read_stl(const std::filesystem::path& path, const StlReadOptions& options) noexcept {
    try {
        return read(path, options);
    } catch (...) {                                          // bad_alloc, or threads that the system would not start
        return Error{Code::out_of_memory, "out of memory"};  // short enough to need none
    }
}

}  // namespace lamella
