#include "io/stream/ply_faces.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "base/guard.hpp"
#include "base/words.hpp"
#include "io/read/ply/ply_body.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

constexpr std::size_t index_bytes = 3 * sizeof(std::uint32_t);  // of a triangle
constexpr std::string_view makes_plain = "'lamella convert MESH -o NEW.ply' makes a file of triangles alone";
constexpr std::size_t piece_bytes = 128 << 10;  // of vertices, a thread

}  // namespace

Result<std::unique_ptr<TriangleFile>> PlyFaces::open(InputFile& file, std::string_view beginning, const Parallel& parallel) {
    std::unique_ptr<PlyFaces> faces(new PlyFaces(std::move(file), beginning));
    const ReadOptions options;
    if (Status status = faces->prepare(FileSource(faces->file_, options, parallel)); !status) {
        return status.error();
    }
    return {std::move(faces)};
}

Status PlyFaces::prepare(const FileSource& source) {
    try {
        header_ = parse_ply_header(beginning_);
    } catch (const TextError& error) {
        if (beginning_.size() < file_.size() && beginning_.find("end_header") == std::string::npos) {
            return source.error(ErrorCode::invalid_argument,
                                "has a header of more than 64 KiB, which is not read within a "
                                "budget of memory");
        }
        return source.error_in_text(beginning_, error);
    }
    const bool has_faces = header_.element_of(PlyRole::faces) != nullptr;
    if (!has_faces && header_.element_of(PlyRole::strips) == nullptr) {
        return source.error(ErrorCode::empty_mesh, "holds no faces");
    }
    if (header_.element_of(PlyRole::vertices) == nullptr) {
        return source.error(ErrorCode::malformed_mesh, "holds faces but no vertices");
    }
    if (header_.encoding == PlyEncoding::ascii) {
        return source.error(ErrorCode::invalid_argument,
                            "is a text PLY file: " + std::string(formats_in_pieces) + std::string(makes_ply));
    }
    return locate(source);
}

/// Where vertices and faces begin. Rows are of one size, or the file is refused.
Status PlyFaces::locate(const FileSource& source) {
    std::uint64_t at = header_.body;
    std::optional<std::uint64_t> complete_rows;  // of faces that the file ends within
    for (const PlyElement& element : header_.elements) {
        const bool is_faces = element.role == PlyRole::faces;
        const std::size_t triangle = is_faces ? triangle_row_bytes(element).value_or(0) : 0;
        if (element.count > 0 && element.has_lists() && triangle == 0) {
            return source.error(ErrorCode::invalid_argument,
                                "element " + short_name(element.name) +
                                    " has other lists than three whole numbers a face, which cannot be sliced within a "
                                    "budget of memory; " +
                                    std::string(makes_plain));
        }
        const std::uint64_t least = element.least_row_bytes(header_.encoding);
        const std::uint64_t left = file_.size() - at;
        if (least > 0 && element.count > left / least) {
            return at_byte(ErrorCode::malformed_mesh, at,
                           "the header counts " + std::to_string(element.count) + " of element " + short_name(element.name) +
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
        return source.error(ErrorCode::invalid_argument, "has more than 2^31 vertices or 2^32 - 2 faces");
    }
    describe(source, at);
    return complete_rows ? Status(first_problem(*complete_rows)) : Status();
}

void PlyFaces::describe(const FileSource& source, std::uint64_t end) {
    facts_.format = MeshFormat::ply;
    facts_.coordinate_type = number_for(points());
    facts_.stride = 3 * size_of(facts_.coordinate_type);
    facts_.vertex_count = points().count;
    facts_.triangle_count = faces().count;
    warn_of_skipped_lines(source, beginning_, header_, facts_.warnings);
    warn_of_rest(source, file_.size() - end, facts_.warnings);
    header_.patient_frame.give(source, facts_);
}

void PlyFaces::load(const Memory* memory, const Parallel& parallel) {
    vertices_ = Array<std::byte>(memory);
    vertices_.resize_discarding(resident_bytes());
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
        copy_vertex_rows(points(), swapped(), as_text(rows).data(), count, facts_.coordinate_type,
                         vertices_.data() + first * facts_.stride);
    });
}

std::size_t PlyFaces::buffer_bytes() const noexcept {
    return index_bytes + face_bytes_;
}

MeshView PlyFaces::read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const {
    auto* const indices = reinterpret_cast<std::uint32_t*>(buffer.data());
    const std::span<std::byte> rows = buffer.subspan(count * index_bytes, count * face_bytes_);
    read_bytes(faces_at_ + first * face_bytes_, rows);
    if (!copy_triangle_rows(faces(), swapped(), as_text(rows).data(), count, facts_.vertex_count, indices)) {
        throw Refused{problem_in(first, as_text(rows))};
    }
    return MeshView::indexed(vertices_.data(), facts_.vertex_count, facts_.stride, facts_.coordinate_type,
                             std::span<const std::uint32_t>(indices, 3 * count));
}

// --- Faces that are wrong

/// Of a file that ends after so many rows of faces, and a part of the next.
Error PlyFaces::first_problem(std::uint64_t complete_rows) {
    std::vector<std::byte> buffer(buffer_bytes() * std::max<std::size_t>(1, piece_bytes / buffer_bytes()));
    const std::size_t piece = buffer.size() / buffer_bytes();
    for (std::uint64_t first = 0; first < complete_rows; first += piece) {
        (void)read(first, std::min<std::uint64_t>(piece, complete_rows - first), buffer);
    }
    const std::uint64_t at = faces_at_ + complete_rows * face_bytes_;
    const std::span<std::byte> tail = std::span(buffer).first(file_.size() - at);
    read_bytes(at, tail);
    return problem_in(complete_rows, as_text(tail));
}

/// The first that is wrong in `rows`, the last of which may be cut off by the end of the file, or be none of its bytes.
Error PlyFaces::problem_in(std::uint64_t first_row, std::string_view rows) const {
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
            return at_byte(ErrorCode::invalid_argument, at + begin,
                           "face " + std::to_string(first_row) + " has " +
                               counted(static_cast<std::uint64_t>(count), "corner") +
                               ": only triangles can be sliced within a budget of memory; " + std::string(makes_plain));
        }
        try {
            PlyRows<BinaryNumbers>({row.data(), end, swapped()}, faces(), first_row).indices(facts_.vertex_count, corners);
        } catch (const TextError& error) {
            return at_byte(ErrorCode::malformed_mesh, at + static_cast<std::size_t>(error.at - rows.data()), error.what);
        }
        begin += face_bytes_;
        ++first_row;
    } while (begin < rows.size());
    return file_.error(ErrorCode::unreadable_file, "changed while it was read");
}

Error PlyFaces::at_byte(ErrorCode code, std::uint64_t byte, const std::string& what) const {
    return file_.error(code, "byte " + std::to_string(byte) + ": " + what, static_cast<std::int64_t>(byte));
}

}  // namespace lamella
