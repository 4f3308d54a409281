#include "io/stream/triangle_file.hpp"

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/read/ply/ply_rows.hpp"
#include "io/read/reader.hpp"

namespace lamella {

namespace {

/// Words of refusals: why, and what to do.
constexpr std::string_view formats_in_pieces = "only binary STL and PLY can be sliced within a budget of memory; ";
constexpr std::string_view makes_ply = "'lamella convert MESH -o MESH.ply' makes the latter of it";

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
    if (gzip || !is_binary_stl(source) || format_of(source) != name_of(MeshFormat::stl)) {
        refuse_format(source);
    }
    MeshFile facts = describe_binary_stl(source);
    return std::make_unique<StlTriangles>(std::move(file), std::move(facts));
}

constexpr std::size_t index_bytes = 3 * sizeof(std::uint32_t);  // of a triangle
constexpr std::string_view makes_plain = "'lamella convert MESH -o NEW.ply' makes a file of triangles alone";
constexpr std::size_t piece_bytes = 128 << 10;  // of vertices, a thread

/// A binary PLY file of triangles: its vertices stay in memory, its faces are read in pieces.
///
///     header | vertices: rows of one size | faces: rows of one size, a list of three indices among what else they have |
///     ...
class PlyFaces final : public TriangleFile {
public:
    PlyFaces(InputFile file, std::string_view beginning) : TriangleFile(std::move(file)), beginning_(beginning) {}

    void prepare(const Parallel& parallel) {
        const ReadOptions options;
        const FileSource source(file_, options, parallel);
        try {
            header_ = parse_ply_header(source, beginning_);
        } catch (const TextError& error) {
            if (beginning_.size() < file_.size() && beginning_.find("end_header") == std::string::npos) {
                source.refuse(ErrorCode::invalid_argument,
                              "has a header of more than 64 KiB, which is not read within a budget of memory");
            }
            throw Refused{source.error_in_text(beginning_, error)};
        }
        if (header_.encoding == PlyEncoding::ascii) {
            source.refuse(ErrorCode::invalid_argument,
                          "is a text PLY file: " + std::string(formats_in_pieces) + std::string(makes_ply));
        }
        locate(source);
    }

    std::uint64_t resident_bytes() const noexcept override { return facts_.vertex_count * facts_.stride; }

    Array<std::byte> load(const Parallel& parallel) const override {
        Array<std::byte> vertices(parallel.memory());
        vertices.resize_discarding(resident_bytes());
        const std::size_t row = points().row_bytes();
        const std::size_t piece = std::max<std::size_t>(1, piece_bytes / row);
        std::vector<std::vector<std::byte>> buffers(static_cast<std::size_t>(parallel.threads()));
        parallel.run((facts_.vertex_count + piece - 1) / piece, [&](std::size_t i, int worker) {
            std::vector<std::byte>& buffer = buffers[static_cast<std::size_t>(worker)];
            buffer.resize(piece * row);
            const std::uint64_t first = std::uint64_t{i} * piece;
            const std::size_t count = std::min<std::uint64_t>(piece, facts_.vertex_count - first);
            const std::span<std::byte> rows = std::span(buffer).first(count * row);
            read_bytes(vertices_at_ + first * row, rows);
            copy_vertices(as_text(rows), count, vertices.data() + first * facts_.stride);
        });
        return vertices;
    }

    std::size_t buffer_bytes() const noexcept override { return index_bytes + face_bytes_; }

    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer,
                  std::span<const std::byte> vertices) const override {
        auto* const indices = reinterpret_cast<std::uint32_t*>(buffer.data());
        const std::span<std::byte> rows = buffer.subspan(count * index_bytes, count * face_bytes_);
        read_bytes(faces_at_ + first * face_bytes_, rows);
        if (!copy_triangle_rows(faces(), header_.swapped(), as_text(rows).data(), count, facts_.vertex_count, indices)) {
            refuse_first_wrong(first);
        }
        return {.vertices = vertices.data(),
                .vertex_count = static_cast<std::size_t>(facts_.vertex_count),
                .triangle_count = count,
                .indices = indices,
                .vertex_type = facts_.vertex_type,
                .mm_per_unit = facts_.mm_per_unit};
    }

private:
    /// Where vertices and faces begin. Rows are of one size, or the file is refused.
    void locate(const FileSource& source) {
        std::uint64_t at = header_.body;
        bool is_cut_off = false;
        for (const PlyElement& element : header_.elements) {
            const bool is_faces = element.role == PlyRole::faces;
            const std::size_t triangle = is_faces ? triangle_row_bytes(element) : 0;
            if (element.count > 0 && element.has_lists() && triangle == 0) {
                source.refuse(ErrorCode::invalid_argument,
                              "element " + in_quotes(element.name) +
                                  " has other lists than three whole numbers a face, which cannot be sliced within a "
                                  "budget of memory; " +
                                  std::string(makes_plain));
            }
            const std::uint64_t left = file_.size() - at;
            if (const std::string what = header_.why_too_many(element, left); !what.empty()) {
                refuse_at(ErrorCode::malformed_mesh, at, what);
            }
            vertices_at_ = element.role == PlyRole::vertices ? at : vertices_at_;
            if (is_faces) {
                faces_at_ = at;
                face_bytes_ = triangle;
                is_cut_off = element.count > left / triangle;
            }
            if (is_cut_off) {
                break;
            }
            at += element.count * (is_faces ? triangle : element.row_bytes());
        }
        if (points().count > most_ply_vertices || faces().count >= std::numeric_limits<std::uint32_t>::max()) {
            source.refuse(ErrorCode::invalid_argument, "has more than 2^31 vertices or 2^32 - 2 faces");
        }
        facts_.format = MeshFormat::ply;
        facts_.vertex_type = number_for(points());
        facts_.stride = 3 * size_of(facts_.vertex_type);
        facts_.vertex_count = points().count;
        facts_.triangle_count = faces().count;
        if (is_cut_off) {
            refuse_first_wrong(0);
        }
        header_.describe(source, beginning_, facts_);
        warn_of_rest(source, file_.size() - at, facts_);
    }

    void copy_vertices(std::string_view rows, std::size_t count, std::byte* to) const {
        if (has_packed_coordinates(points())) {
            return copy_coordinates(facts_.vertex_type, header_.swapped(), rows.data() + points().row_bytes(PlyUse::x),
                                    points().row_bytes(), count, to, facts_.stride);
        }
        PlyRows<BinaryNumbers> numbers({rows.data(), rows.data() + rows.size(), header_.swapped()}, points());
        for (std::size_t i = 0; i < count; ++i) {
            numbers.vertex(facts_.vertex_type, to + i * facts_.stride);
        }
    }

    /// The first from `row` on that is wrong: the last may be cut off by the end of the file, or be none of its bytes.
    [[noreturn]] void refuse_first_wrong(std::uint64_t row) const {
        std::vector<std::byte> piece(face_bytes_ * std::max<std::size_t>(1, piece_bytes / face_bytes_));
        while (row < faces().count) {
            const std::uint64_t at = faces_at_ + row * face_bytes_;
            const std::span<std::byte> rows =
                std::span(piece).first(std::min<std::uint64_t>(piece.size(), file_.size() - at));
            read_bytes(at, rows);
            for (std::size_t begin = 0; begin < piece.size() && row < faces().count; begin += face_bytes_, ++row) {
                check_row(row, as_text(rows).substr(std::min(begin, rows.size()), face_bytes_));
            }
        }
        throw Refused{file_.error(ErrorCode::unreadable_file, "changed while it was read")};
    }

    void check_row(std::uint64_t number, std::string_view row) const {
        const std::uint64_t at = faces_at_ + number * face_bytes_;
        const char* const end = row.data() + row.size();
        std::int64_t count = 3;
        BinaryNumbers length(row.data() + std::min(faces().row_bytes(PlyUse::indices), row.size()), end, header_.swapped());
        if (length.integer(faces().used(PlyUse::indices).count_type, count) && count >= 0 && count != 3) {
            refuse_at(ErrorCode::invalid_argument, at,
                      "face " + std::to_string(number) + " has " + counted(static_cast<std::uint64_t>(count), "corner") +
                          ": only triangles can be sliced within a budget of memory; " + std::string(makes_plain));
        }
        std::vector<std::uint32_t> corners;
        try {
            PlyRows<BinaryNumbers>({row.data(), end, header_.swapped()}, faces(), number)
                .indices(facts_.vertex_count, corners);
        } catch (const TextError& error) {
            refuse_at(ErrorCode::malformed_mesh, at + static_cast<std::size_t>(error.at - row.data()), error.what);
        }
    }

    [[noreturn]] void refuse_at(ErrorCode code, std::uint64_t byte, const std::string& what) const {
        throw Refused{file_.error(code, "byte " + std::to_string(byte) + ": " + what, static_cast<std::int64_t>(byte))};
    }

    const PlyElement& faces() const noexcept { return *header_.element_of(PlyRole::faces); }
    const PlyElement& points() const noexcept { return *header_.element_of(PlyRole::vertices); }

    const std::string beginning_;  ///< names in the header refer into it
    PlyHeader header_;
    std::uint64_t vertices_at_ = 0;  ///< bytes in the file
    std::uint64_t faces_at_ = 0;
    std::size_t face_bytes_ = 0;
};

std::unique_ptr<TriangleFile> open_ply_faces(InputFile& file, std::string_view beginning, const Parallel& parallel) {
    auto faces = std::make_unique<PlyFaces>(std::move(file), beginning);
    faces->prepare(parallel);
    return faces;
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
    file->facts_.mm_per_unit = options.mm_per_unit != 0 ? options.mm_per_unit : 1;
    file->facts_.file_bytes = file->file_.size();
    file->facts_.read_ms = milliseconds_since(start);
    return file;
}

}  // namespace lamella
