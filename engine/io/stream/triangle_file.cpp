#include "io/stream/triangle_file.hpp"

#include <utility>

#include "base/guard.hpp"
#include "io/read/gzip.hpp"
#include "io/read/reader.hpp"

namespace lamella {

namespace {

/// Why a file cannot be read in pieces, and what to do.
Error not_in_pieces(const FileSource& source) {
    const std::string advice = ": only binary STL can be sliced within a budget of memory; ";
    if (source.sample().starts_with(gzip_magic)) {
        return source.error(ErrorCode::invalid_argument, "is compressed by gzip" + advice + "decompress it with gunzip");
    }
    const std::string_view format = format_of(source);
    if (format.empty()) {
        return source.error(ErrorCode::malformed_mesh,
                            "is no binary STL file" + advice + "nothing else is known of this one", 0);
    }
    const std::string kind = is_text(source.sample()) ? "a text " : "a binary ";
    return source.error(ErrorCode::invalid_argument,
                        "is " + kind + std::string(format) + " file" + advice + "convert it to that");
}

}  // namespace

Result<TriangleFile> TriangleFile::open(const std::filesystem::path& path, std::string_view name, double mm_per_unit,
                                        const Parallel& parallel) {
    Result<InputFile> opened = InputFile::open(path, name);
    if (!opened) {
        return opened.error();
    }
    InputFile file = std::move(opened).value();
    const ReadOptions options;
    FileSource source(file, options, parallel);
    if (source.size() == 0) {
        return source.error(ErrorCode::empty_mesh, "is empty");
    }
    if (Status got = source.read_sample(); !got) {
        return got.error();
    }
    const bool gzip = source.sample().starts_with(gzip_magic);
    if (!gzip && !is_binary_stl(source) && format_of(source).empty() && is_named_as_mesh(path)) {
        const Result<MeshFile> described = describe_binary_stl(source);  // truncated, or too short to have a header
        return described ? not_in_pieces(source) : described.error();
    }
    if (gzip || !is_binary_stl(source)) {
        return not_in_pieces(source);
    }
    Result<MeshFile> facts = describe_binary_stl(source);
    if (!facts) {
        return facts.error();
    }
    facts->mm_per_unit = mm_per_unit;
    facts->file_bytes = file.size();
    return TriangleFile(std::move(file), std::move(facts).value());
}

MeshView TriangleFile::read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const {
    // The last triangle's attribute is not read, but coordinates of 36 bytes are.
    const std::span<std::byte> into = buffer.first((count - 1) * stride + 9 * sizeof(float));
    if (Status got = file_.read_at(facts_.first_offset + first * stride, into); !got) {
        throw Refused{got.error()};
    }
    return MeshView::strided_soup(into.data(), count, stride, CoordinateType::f32);
}

Error TriangleFile::named(Error error) const {
    error.message = file_.name() + ": " + error.message;
    return error;
}

}  // namespace lamella
