#include "io/stream/triangle_file.hpp"

#include "base/clock.hpp"
#include "io/read/reader.hpp"

namespace lamella {

namespace {

/// Says why a file cannot be read in pieces, and what to do.
[[noreturn]] void refuse_format(const FileSource& source) {
    const std::string advice = ": " + std::string(formats_in_pieces);
    if (source.sample().starts_with(gzip_magic)) {
        source.refuse(ErrorCode::invalid_argument, "is compressed by gzip" + advice + "decompress it with gunzip");
    }
    const std::string_view format = format_of(source);
    if (format.empty()) {
        source.refuse(ErrorCode::malformed_mesh,
                      "is no binary STL or PLY file" + advice + "nothing else is known of this one", 0);
    }
    const std::string kind = is_text(source.sample()) ? "a text " : "a binary ";
    const bool is_soup = format == name_of(MeshFormat::stl);  // whose vertices would take more than its triangles
    source.refuse(ErrorCode::invalid_argument,
                  "is " + kind + std::string(format) + " file" + advice +
                      std::string(is_soup ? "'lamella convert MESH -o MESH.stl' makes the former of it" : makes_ply));
}

class StlTriangles final : public TriangleFile {
public:
    StlTriangles(InputFile file, MeshFile facts) : TriangleFile(std::move(file)) { facts_ = std::move(facts); }

    std::size_t buffer_bytes() const noexcept override { return stride; }

    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer,
                  std::span<const std::byte> /*resident*/) const override {
        // The last triangle's attribute is not read, but coordinates of 36 bytes are.
        const std::span<std::byte> into = buffer.first((count - 1) * stride + 9 * sizeof(float));
        read_bytes(facts_.first_offset + first * stride, into);
        return {
            .vertices = into.data(), .triangle_count = count, .vertex_stride = stride, .mm_per_unit = facts_.mm_per_unit};
    }

private:
    static constexpr std::size_t stride = 50;
};

std::unique_ptr<TriangleFile> open_stl(InputFile& file, const FileSource& source, const std::filesystem::path& path) {
    const bool gzip = source.sample().starts_with(gzip_magic);
    if (!gzip && !is_binary_stl(source) && format_of(source).empty() && is_named_as_mesh(path)) {
        (void)describe_binary_stl(source);  // refuses what is truncated, or too short to have a header
    }
    if (gzip || !is_binary_stl(source)) {
        refuse_format(source);
    }
    MeshFile facts = describe_binary_stl(source);
    return std::make_unique<StlTriangles>(std::move(file), std::move(facts));
}

}  // namespace

std::unique_ptr<TriangleFile> TriangleFile::open(const std::filesystem::path& path, const ReadOptions& options) {
    const Clock::time_point start = Clock::now();
    InputFile opened = require(InputFile::open(path, options.name));
    const Parallel parallel({.threads = 1});
    FileSource source(opened, options, parallel);
    if (source.size() == 0) {
        source.refuse(ErrorCode::empty_mesh, "is empty");
    }
    const bool is_ply = looks_like_ply(source) && !is_binary_stl(source);
    std::unique_ptr<TriangleFile> file =
        is_ply ? open_ply_faces(opened, source.sample(), parallel) : open_stl(opened, source, path);
    file->facts_.mm_per_unit = options.mm_per_unit;
    file->facts_.file_bytes = file->file_.size();
    file->facts_.read_ms = milliseconds_since(start);
    return file;
}

}  // namespace lamella
