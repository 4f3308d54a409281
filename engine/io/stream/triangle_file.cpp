#include "io/stream/triangle_file.hpp"

#include <utility>

#include "base/guard.hpp"
#include "io/read/gzip.hpp"
#include "io/read/reader.hpp"
#include "io/stream/ply_faces.hpp"

namespace lamella {

namespace {

/// Why a file cannot be read in pieces, and what to do.
Error not_in_pieces(const FileSource& source) {
    const std::string advice = ": " + std::string(formats_in_pieces);
    if (source.sample().starts_with(gzip_magic)) {
        return source.error(ErrorCode::invalid_argument, "is compressed by gzip" + advice + "decompress it with gunzip");
    }
    const std::string_view format = format_of(source);
    if (format.empty()) {
        return source.error(ErrorCode::malformed_mesh,
                            "is no binary STL or PLY file" + advice + "nothing else is known of this one", 0);
    }
    const std::string kind = is_text(source.sample()) ? "a text " : "a binary ";
    const bool is_soup = format == name_of(MeshFormat::stl);  // whose vertices would take more than its triangles
    return source.error(ErrorCode::invalid_argument,
                        "is " + kind + std::string(format) + " file" + advice +
                            std::string(is_soup ? "'lamella convert MESH -o MESH.stl' makes the former of it" : makes_ply));
}

class StlTriangles final : public TriangleFile {
public:
    StlTriangles(InputFile file, MeshFile facts) : TriangleFile(std::move(file)) { facts_ = std::move(facts); }

    std::size_t buffer_bytes() const noexcept override { return stride; }

    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const override {
        // The last triangle's attribute is not read, but coordinates of 36 bytes are.
        const std::span<std::byte> into = buffer.first((count - 1) * stride + 9 * sizeof(float));
        read_bytes(facts_.first_offset + first * stride, into);
        return MeshView::strided_soup(into.data(), count, stride, CoordinateType::f32);
    }

private:
    static constexpr std::size_t stride = 50;
};

Result<std::unique_ptr<TriangleFile>> open_stl(InputFile& file, const FileSource& source,
                                               const std::filesystem::path& path) {
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
    return {std::make_unique<StlTriangles>(std::move(file), std::move(facts).value())};
}

}  // namespace

Result<std::unique_ptr<TriangleFile>> TriangleFile::open(const std::filesystem::path& path, std::string_view name,
                                                         double mm_per_unit, const Parallel& parallel) {
    Result<InputFile> opened = InputFile::open(path, name);
    if (!opened) {
        return opened.error();
    }
    const ReadOptions options;
    FileSource source(*opened, options, parallel);
    if (source.size() == 0) {
        return source.error(ErrorCode::empty_mesh, "is empty");
    }
    if (Status got = source.read_sample(); !got) {
        return got.error();
    }
    const bool is_ply = looks_like_ply(source) && !is_binary_stl(source);
    Result<std::unique_ptr<TriangleFile>> file =
        is_ply ? PlyFaces::open(*opened, source.sample(), parallel) : open_stl(*opened, source, path);
    if (file) {
        MeshFile& facts = (*file)->facts();
        facts.mm_per_unit = mm_per_unit;
        facts.file_bytes = (*file)->file_.size();
    }
    return file;
}

void TriangleFile::read_bytes(std::uint64_t offset, std::span<std::byte> into) const {
    if (Status got = file_.read_at(offset, into); !got) {
        throw Refused{got.error()};
    }
}

Error TriangleFile::named(Error error) const {
    error.message = file_.name() + ": " + error.message;
    return error;
}

}  // namespace lamella
