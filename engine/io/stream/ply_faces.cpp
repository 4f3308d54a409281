// A binary PLY file of triangles: its vertices stay in memory, its faces are read in pieces.
//
//     header | vertices: rows of one size | faces: rows of one size, a list of three indices among what else they have | ...

#include "base/words.hpp"
#include "io/read/ply/ply.hpp"
#include "io/read/ply/ply_rows.hpp"
#include "io/stream/triangle_file.hpp"

namespace lamella {

namespace {

constexpr std::size_t index_bytes = 3 * sizeof(std::uint32_t);  // of a triangle
constexpr std::string_view makes_plain = "'lamella convert MESH -o NEW.ply' makes a file of triangles alone";
constexpr std::size_t piece_bytes = 128 << 10;  // of vertices, a thread

class PlyFaces final : public TriangleFile {
public:
    PlyFaces(InputFile file, std::string_view beginning) : TriangleFile(std::move(file)), beginning_(beginning) {}

    void prepare(const Parallel& parallel) {
        const ReadOptions options;
        const FileSource source(file_, options, parallel);
        try {
            header_ = parse_ply_header(beginning_);
        } catch (const TextError& error) {
            if (beginning_.size() < file_.size() && beginning_.find("end_header") == std::string::npos) {
                source.refuse(ErrorCode::invalid_argument,
                              "has a header of more than 64 KiB, which is not read within a budget of memory");
            }
            throw Refused{source.error_in_text(beginning_, error)};
        }
        check_ply_header(source, header_);
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
        const std::size_t row = points().least_row_bytes(header_.encoding);
        const std::size_t piece = std::max<std::size_t>(1, piece_bytes / row);
        std::vector<std::vector<std::byte>> buffers(static_cast<std::size_t>(parallel.threads()));
        parallel.run((facts_.vertex_count + piece - 1) / piece, [&](std::size_t i, int worker) {
            std::vector<std::byte>& buffer = buffers[static_cast<std::size_t>(worker)];
            buffer.resize(piece * row);
            const std::uint64_t first = std::uint64_t{i} * piece;
            const std::size_t count = std::min<std::uint64_t>(piece, facts_.vertex_count - first);
            const std::span<std::byte> rows = std::span(buffer).first(count * row);
            read_bytes(vertices_at_ + first * row, rows);
            copy_vertex_rows(points(), swapped(), as_text(rows).data(), count, facts_.vertex_type,
                             vertices.data() + first * facts_.stride);
        });
        return vertices;
    }

    std::size_t buffer_bytes() const noexcept override { return index_bytes + face_bytes_; }

    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer,
                  std::span<const std::byte> vertices) const override {
        auto* const indices = reinterpret_cast<std::uint32_t*>(buffer.data());
        const std::span<std::byte> rows = buffer.subspan(count * index_bytes, count * face_bytes_);
        read_bytes(faces_at_ + first * face_bytes_, rows);
        if (!copy_triangle_rows(faces(), swapped(), as_text(rows).data(), count, facts_.vertex_count, indices)) {
            refuse_first_wrong(first, as_text(rows));
        }
        return {.vertices = vertices.data(),
                .vertex_count = facts_.vertex_count,
                .triangle_count = count,
                .indices = indices,
                .vertex_type = facts_.vertex_type,
                .mm_per_unit = facts_.mm_per_unit};
    }

private:
    /// Where vertices and faces begin. Rows are of one size, or the file is refused.
    void locate(const FileSource& source) {
        std::uint64_t at = header_.body;
        std::optional<std::uint64_t> complete_rows;  // of faces that the file ends within
        for (const PlyElement& element : header_.elements) {
            const bool is_faces = element.role == PlyRole::faces;
            const std::size_t triangle = is_faces ? triangle_row_bytes(element).value_or(0) : 0;
            if (element.count > 0 && element.has_lists() && triangle == 0) {
                source.refuse(ErrorCode::invalid_argument,
                              "element " + in_quotes(element.name) +
                                  " has other lists than three whole numbers a face, which cannot be sliced within a "
                                  "budget of memory; " +
                                  std::string(makes_plain));
            }
            const std::uint64_t least = element.least_row_bytes(header_.encoding);
            const std::uint64_t left = file_.size() - at;
            if (least > 0 && element.count > left / least) {
                refuse_at(ErrorCode::malformed_mesh, at,
                          "the header counts " + std::to_string(element.count) + " of element " + in_quotes(element.name) +
                              ", but " + std::to_string(left) + " bytes are left");
            }
            vertices_at_ = element.role == PlyRole::vertices ? at : vertices_at_;
            if (is_faces) {
                faces_at_ = at;
                face_bytes_ = triangle;
            }
            const std::uint64_t row = is_faces ? triangle : least;
            if (row > 0 && element.count > left / row) {
                complete_rows = left / row;
                break;
            }
            at += element.count * row;
        }
        if (points().count > most_ply_vertices || faces().count >= std::numeric_limits<std::uint32_t>::max()) {
            source.refuse(ErrorCode::invalid_argument, "has more than 2^31 vertices or 2^32 - 2 faces");
        }
        describe(source, at);
        if (complete_rows) {
            refuse_cut_off(*complete_rows);
        }
    }

    void describe(const FileSource& source, std::uint64_t end) {
        facts_.format = MeshFormat::ply;
        facts_.vertex_type = number_for(points());
        facts_.stride = 3 * size_of(facts_.vertex_type);
        facts_.vertex_count = points().count;
        facts_.triangle_count = faces().count;
        warn_of_skipped_lines(source, beginning_, header_, facts_.warnings);
        warn_of_rest(source, file_.size() - end, facts_.warnings);
        header_.patient_frame.give(source, facts_);
    }

    /// A file that ends after so many rows of faces, and a part of the next.
    [[noreturn]] void refuse_cut_off(std::uint64_t complete_rows) {
        std::vector<std::byte> buffer(buffer_bytes() * std::max<std::size_t>(1, piece_bytes / buffer_bytes()));
        const std::size_t piece = buffer.size() / buffer_bytes();
        for (std::uint64_t first = 0; first < complete_rows; first += piece) {
            (void)read(first, std::min<std::uint64_t>(piece, complete_rows - first), buffer, {});
        }
        const std::uint64_t at = faces_at_ + complete_rows * face_bytes_;
        const std::span<std::byte> tail = std::span(buffer).first(file_.size() - at);
        read_bytes(at, tail);
        refuse_first_wrong(complete_rows, as_text(tail));
    }

    /// The first that is wrong in `rows`, the last of which may be cut off by the end of the file, or be none of its bytes.
    [[noreturn]] void refuse_first_wrong(std::uint64_t first_row, std::string_view rows) const {
        const std::uint64_t at = faces_at_ + first_row * face_bytes_;
        const std::size_t list = offset_in_row(faces(), PlyUse::indices);
        std::vector<std::uint32_t> corners;
        std::size_t begin = 0;
        do {
            const std::string_view row = rows.substr(begin, face_bytes_);
            const char* const end = row.data() + row.size();
            std::int64_t count = 3;
            BinaryNumbers length(row.data() + std::min(list, row.size()), end, swapped());
            if (length.integer(faces().used(PlyUse::indices).count_type, count) && count >= 0 && count != 3) {
                refuse_at(ErrorCode::invalid_argument, at + begin,
                          "face " + std::to_string(first_row) + " has " +
                              counted(static_cast<std::uint64_t>(count), "corner") +
                              ": only triangles can be sliced within a budget of memory; " + std::string(makes_plain));
            }
            try {
                PlyRows<BinaryNumbers>({row.data(), end, swapped()}, faces(), first_row)
                    .indices(facts_.vertex_count, corners);
            } catch (const TextError& error) {
                refuse_at(ErrorCode::malformed_mesh, at + static_cast<std::size_t>(error.at - rows.data()), error.what);
            }
            begin += face_bytes_;
            ++first_row;
        } while (begin < rows.size());
        throw Refused{file_.error(ErrorCode::unreadable_file, "changed while it was read")};
    }

    [[noreturn]] void refuse_at(ErrorCode code, std::uint64_t byte, const std::string& what) const {
        throw Refused{file_.error(code, "byte " + std::to_string(byte) + ": " + what, static_cast<std::int64_t>(byte))};
    }

    bool swapped() const noexcept { return header_.encoding == PlyEncoding::big_endian; }
    const PlyElement& faces() const noexcept { return *header_.element_of(PlyRole::faces); }
    const PlyElement& points() const noexcept { return *header_.element_of(PlyRole::vertices); }

    const std::string beginning_;  ///< names in the header refer into it
    PlyHeader header_;
    std::uint64_t vertices_at_ = 0;  ///< bytes in the file
    std::uint64_t faces_at_ = 0;
    std::size_t face_bytes_ = 0;
};

}  // namespace

std::unique_ptr<TriangleFile> open_ply_faces(InputFile& file, std::string_view beginning, const Parallel& parallel) {
    auto faces = std::make_unique<PlyFaces>(std::move(file), beginning);
    faces->prepare(parallel);
    return faces;
}

}  // namespace lamella
