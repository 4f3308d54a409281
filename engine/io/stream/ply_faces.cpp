// A binary PLY file of triangles: its vertices stay in memory, its faces are read in pieces.
//
//     header | vertices: rows of one size | faces: rows of one size, a list of three indices among what else they have | ...

#include "base/words.hpp"
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

}  // namespace

std::unique_ptr<TriangleFile> open_ply_faces(InputFile& file, std::string_view beginning, const Parallel& parallel) {
    auto faces = std::make_unique<PlyFaces>(std::move(file), beginning);
    faces->prepare(parallel);
    return faces;
}

}  // namespace lamella
