#include "io/read/ply/ply_lines.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstring>
#include <vector>

#include "io/read/ply/ply_numbers.hpp"
#include "io/read/ply/ply_rows.hpp"
#include "io/read/ply/ply_triangles.hpp"

namespace lamella {

namespace {

constexpr std::size_t lines_bytes = std::size_t{1} << 20;

/// Longer lines are left to the other reader, so that no thread needs much memory for a list.
constexpr std::ptrdiff_t longest_line = std::ptrdiff_t{16} << 10;

/// Whole lines.
struct Piece {
    const char* begin = nullptr;
    const char* end = nullptr;
    std::uint64_t first_row = 0;
    std::uint64_t rows = 0;  ///< lines
    std::uint64_t words = 0;
    std::size_t first_triangle = 0;  ///< where its triangles go, with room for `capacity`
    std::size_t capacity = 0;
    std::size_t triangles = 0;
    std::uint64_t small_faces = 0;

    std::uint64_t end_row() const { return first_row + rows; }
};

/// The rows of one element, counted over the whole body.
struct RowRange {
    const PlyElement* element = nullptr;
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
};

const char* line_end(const char* p, const char* end) {
    const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
    return found != nullptr ? static_cast<const char*>(found) : end;
}

/// Cuts that depend on the text alone.
std::vector<Piece> cut(std::string_view text) {
    const char* const end = text.data() + text.size();
    std::vector<Piece> pieces;
    for (const char* begin = text.data(); begin != end;) {
        Piece& piece = pieces.emplace_back();
        piece.begin = begin;
        const auto left = static_cast<std::size_t>(end - begin);
        piece.end = left > lines_bytes ? line_end(begin + lines_bytes, end) : end;
        piece.end += piece.end != end ? 1 : 0;
        begin = piece.end;
    }
    return pieces;
}

/// Without branches, so that it runs at the speed of memory.
void count(Piece& piece) {
    const auto length = static_cast<std::size_t>(piece.end - piece.begin);
    std::size_t lines = piece.end[-1] != '\n' ? 1 : 0;
    std::size_t words = is_space(piece.begin[0]) ? 0 : 1;
    for (std::size_t i = 0; i < length; ++i) {
        lines += static_cast<std::size_t>(piece.begin[i] == '\n');
    }
    for (std::size_t i = 1; i < length; ++i) {
        words +=
            static_cast<std::size_t>(is_space(piece.begin[i - 1])) & static_cast<std::size_t>(!is_space(piece.begin[i]));
    }
    piece.rows = lines;
    piece.words = words;
}

class LineReader {
public:
    LineReader(const PlyInput& input, PlyMesh& mesh) : input_(input), mesh_(mesh) {}

    bool read();

private:
    bool rows_are_lines();
    bool allocate();
    template <class Task>
    bool for_pieces(const RowRange& rows, Task task);
    bool read_element(const RowRange& rows);
    template <class Value>
    bool read_vertices(const RowRange& rows);
    bool read_faces(const RowRange& rows);
    bool read_over(const RowRange& rows);
    void close_gaps();

    const PlyInput& input_;
    PlyMesh& mesh_;
    std::vector<Piece> pieces_;
    std::vector<RowRange> ranges_;
    std::size_t vertices_ = 0;  // which of the ranges they are
};

bool LineReader::read() {
    if (!rows_are_lines() || !allocate() || !read_element(ranges_[vertices_])) {
        return false;
    }
    for (std::size_t i = 0; i < ranges_.size(); ++i) {
        if (i != vertices_ && !read_element(ranges_[i])) {
            return false;
        }
    }
    close_gaps();
    return true;
}

/// Whether there are as many of the ones as of the others.
bool LineReader::rows_are_lines() {
    std::string_view text = input_.file.substr(input_.header.body);
    while (!text.empty() && is_space(text.back())) {
        text.remove_suffix(1);
    }
    mesh_.end = input_.header.body + text.size();
    pieces_ = cut(text);
    input_.parallel.run(pieces_.size(), [this](std::size_t i, int) { count(pieces_[i]); });
    std::uint64_t lines = 0;
    for (Piece& piece : pieces_) {
        piece.first_row = lines;
        lines += piece.rows;
    }
    std::uint64_t rows = 0;
    for (const PlyElement& element : input_.header.elements) {
        if (element.role == PlyRole::vertices) {
            vertices_ = ranges_.size();
        }
        if (element.count > lines - rows || (element.properties.empty() && element.count > 0)) {
            return false;
        }
        ranges_.push_back({&element, rows, rows + element.count});
        rows += element.count;
    }
    return rows == lines && input_.header.element_of(PlyRole::strips) == nullptr;
}

/// Room for the triangles of each piece: a row of n corners has n - 2 of them and, beside the corners, its length and other
/// properties. Faces of fewer corners than three may make this too little; the other reader takes over then.
bool LineReader::allocate() {
    const PlyElement& vertices = *ranges_[vertices_].element;
    std::size_t triangles = 0;
    for (const RowRange& range : ranges_) {
        if (range.element->role != PlyRole::faces) {
            continue;
        }
        const std::uint64_t words_beside = 2 + range.element->properties.size();
        for (Piece& piece : pieces_) {
            const std::uint64_t begin = std::max(piece.first_row, range.begin);
            const std::uint64_t end = std::min(piece.end_row(), range.end);
            if (begin < end) {
                const std::uint64_t beside = std::min(piece.words, (end - begin) * words_beside);
                piece.first_triangle = triangles;
                piece.capacity = std::max(end - begin, piece.words - beside);
                triangles += piece.capacity;
            }
        }
    }
    const std::uint64_t vertex_bytes = vertices.count * 3 * size_of(number_for(vertices));
    if (vertices.count > strip_end || vertex_bytes + triangles * 3 * sizeof(std::uint32_t) > input_.memory_limit) {
        return false;
    }
    allocate_vertices(vertices, mesh_);
    mesh_.indices.resize_discarding(3 * triangles);
    return true;
}

/// Calls task(piece, line, begin, end) for the pieces that `rows` lie in, in parallel: rows [begin, end) lie from `line` on.
/// False: a task was.
template <class Task>
bool LineReader::for_pieces(const RowRange& rows, Task task) {
    std::atomic<bool> good{true};
    const auto first = std::upper_bound(pieces_.begin(), pieces_.end(), rows.begin,
                                        [](std::uint64_t row, const Piece& piece) { return row < piece.end_row(); });
    const auto last = std::lower_bound(first, pieces_.end(), rows.end,
                                       [](const Piece& piece, std::uint64_t row) { return piece.first_row < row; });
    input_.parallel.run(static_cast<std::size_t>(last - first), [&](std::size_t i, int) {
        Piece& piece = first[static_cast<std::ptrdiff_t>(i)];
        const char* line = piece.begin;
        for (std::uint64_t row = piece.first_row; row < rows.begin; ++row) {
            line = line_end(line, piece.end) + 1;
        }
        const std::uint64_t begin = std::max(piece.first_row, rows.begin);
        if (good.load(std::memory_order_relaxed) && !task(piece, line, begin, std::min(piece.end_row(), rows.end))) {
            good.store(false, std::memory_order_relaxed);
        }
    });
    return good;
}

bool LineReader::read_element(const RowRange& rows) {
    if (rows.begin == rows.end) {
        return true;
    }
    if (rows.element->role == PlyRole::vertices) {
        return mesh_.coordinate_type == CoordinateType::f64 ? read_vertices<double>(rows) : read_vertices<float>(rows);
    }
    return rows.element->role == PlyRole::faces ? read_faces(rows) : read_over(rows);
}

/// Reads rows [begin, end), which lie from `line` on, each by read(parser). False: one is not as it should be, or not alone
/// on its line.
template <class Read>
bool read_lines(const Piece& piece, const char* line, std::uint64_t begin, std::uint64_t end, const PlyElement& element,
                Read read) {
    for (std::uint64_t row = begin; row < end; ++row) {
        const char* const stop = line_end(line, piece.end);
        PlyRows<AsciiNumbers> parser(AsciiNumbers(line, stop), element, row);
        if (stop - line > longest_line || !read(parser) || !AsciiNumbers(parser.numbers()).at_end()) {
            return false;
        }
        line = stop != piece.end ? stop + 1 : stop;
    }
    return true;
}

template <class Value>
bool LineReader::read_vertices(const RowRange& rows) {
    return for_pieces(rows, [&](const Piece& piece, const char* line, std::uint64_t begin, std::uint64_t end) {
        std::byte* out = mesh_.coordinates.data() + (begin - rows.begin) * 3 * sizeof(Value);
        return read_lines(piece, line, begin, end, *rows.element, [&out](PlyRows<AsciiNumbers>& parser) {
            Value xyz[3];
            const bool read = parser.vertex(xyz);
            if (read) {
                std::memcpy(out, xyz, sizeof xyz);
                out += sizeof xyz;
            }
            return read;
        });
    });
}

bool LineReader::read_faces(const RowRange& rows) {
    const VertexCoordinates vertices = {mesh_.coordinates.data(), mesh_.stride, mesh_.coordinate_type};
    return for_pieces(rows, [&](Piece& piece, const char* line, std::uint64_t begin, std::uint64_t end) {
        PlyTriangles triangles(vertices, mesh_.indices.span().subspan(3 * piece.first_triangle, 3 * piece.capacity));
        std::vector<std::uint32_t> list;
        const bool good = read_lines(piece, line, begin, end, *rows.element, [&](PlyRows<AsciiNumbers>& parser) {
            return parser.indices(mesh_.vertex_count, list) && triangles.add_face(list);
        });
        piece.triangles = triangles.index_count() / 3;
        piece.small_faces = triangles.small_faces();
        return good;
    });
}

bool LineReader::read_over(const RowRange& rows) {
    return for_pieces(rows, [&](const Piece& piece, const char* line, std::uint64_t begin, std::uint64_t end) {
        PlyLists lists;
        return read_lines(piece, line, begin, end, *rows.element,
                          [&lists](PlyRows<AsciiNumbers>& parser) { return parser.skip(lists); });
    });
}

/// Where pieces turned out to hold fewer triangles than there was room for.
void LineReader::close_gaps() {
    std::size_t triangles = 0;
    for (const Piece& piece : pieces_) {
        if (piece.triangles > 0 && piece.first_triangle != triangles) {
            std::uint32_t* const indices = mesh_.indices.data();
            std::memmove(indices + 3 * triangles, indices + 3 * piece.first_triangle, 12 * piece.triangles);
        }
        triangles += piece.triangles;
        mesh_.small_faces += piece.small_faces;
    }
    mesh_.indices.set_size(3 * triangles);
}

}  // namespace

bool read_ply_lines(const PlyInput& input, PlyMesh& mesh) {
    PlyMesh attempt(mesh.indices.memory());
    if (!LineReader(input, attempt).read()) {
        return false;
    }
    mesh = std::move(attempt);
    return true;
}

}  // namespace lamella
