#include "io/read/ply/ply_lines.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <vector>

#include "io/read/ply/ply_numbers.hpp"
#include "io/read/ply/ply_rows.hpp"
#include "io/read/ply/ply_triangles.hpp"
#include "io/text/pieces.hpp"

namespace lamella {

namespace {

/// Longer lines are left to the other reader, so that no thread needs much memory for a list.
constexpr std::ptrdiff_t longest_line = std::ptrdiff_t{16} << 10;

/// What is counted in a piece of whole lines, and made of it.
struct PieceFaces {
    std::uint64_t words = 0;
    ItemRun triangles;
    std::size_t most_triangles = 0;  ///< for which there is room from triangles.first on
    std::uint64_t small_faces = 0;
    LeftOut long_rows;
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

std::vector<TextPiece> cut_after_newlines(std::string_view text) {
    const char* const end = text.data() + text.size();
    return cut_text(text, text_piece_bytes, [end](const char*, const char* from) {
        const char* const cut = line_end(from, end);
        return cut + (cut != end ? 1 : 0);
    });
}

/// The last may lack its end.
std::size_t count_lines(std::string_view text) {
    const auto ends =
        static_cast<std::size_t>(text.front() == '\n') + count_in(text, [](char, char c) { return c == '\n'; });
    return ends + (text.back() != '\n' ? 1 : 0);
}

/// A line that is not as usual: the reader that goes from number to number says what is wrong there, if anything is.
struct OddLine {
    const char* at = nullptr;  ///< null: none
};

class LineReader {
public:
    LineReader(const PlyInput& input, bool takes_long_rows, PlyMesh& mesh)
        : input_(input), takes_long_rows_(takes_long_rows), mesh_(mesh) {}

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
    void join_triangles();

    template <class Read>
    bool read_lines(std::size_t piece, const char* line, std::uint64_t begin, std::uint64_t end, const PlyElement& element,
                    Read read);

    const PlyInput& input_;
    bool takes_long_rows_;
    PlyMesh& mesh_;
    std::vector<TextPiece> pieces_;  // of lines, each a row
    std::vector<PieceFaces> faces_;  // per piece
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
    join_triangles();
    return true;
}

/// Whether the body has as many lines as rows.
bool LineReader::rows_are_lines() {
    std::string_view text = input_.file.substr(input_.header.body);
    while (!text.empty() && is_space(text.back())) {
        text.remove_suffix(1);
    }
    mesh_.end = input_.header.body + text.size();
    pieces_ = cut_after_newlines(text);
    faces_.resize(pieces_.size());
    input_.parallel.run(pieces_.size(), [this](std::size_t i, int) {
        pieces_[i].count = count_lines(pieces_[i].text);
        faces_[i].words = count_words(pieces_[i].text);
    });
    const std::uint64_t lines = number_items(pieces_);
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
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            const std::uint64_t begin = std::max<std::uint64_t>(pieces_[i].first, range.begin);
            const std::uint64_t end = std::min<std::uint64_t>(pieces_[i].end_item(), range.end);
            if (begin < end) {
                PieceFaces& own = faces_[i];
                const std::uint64_t beside = std::min(own.words, (end - begin) * words_beside);
                own.triangles.first = triangles;
                own.most_triangles = std::max(end - begin, own.words - beside);
                triangles += own.most_triangles;
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
/// False: a task returned false.
template <class Task>
bool LineReader::for_pieces(const RowRange& rows, Task task) {
    const auto first = std::upper_bound(pieces_.begin(), pieces_.end(), rows.begin,
                                        [](std::uint64_t row, const TextPiece& piece) { return row < piece.end_item(); });
    const auto last = std::lower_bound(first, pieces_.end(), rows.end,
                                       [](const TextPiece& piece, std::uint64_t row) { return piece.first < row; });
    const auto skipped = static_cast<std::size_t>(first - pieces_.begin());
    const auto parse = [&](std::size_t i, int) {
        const TextPiece& piece = pieces_[skipped + i];
        const char* line = piece.begin();
        for (std::uint64_t row = piece.first; row < rows.begin; ++row) {
            line = line_end(line, piece.end()) + 1;
        }
        const std::uint64_t begin = std::max<std::uint64_t>(piece.first, rows.begin);
        const std::uint64_t end = std::min<std::uint64_t>(piece.end_item(), rows.end);
        return task(skipped + i, line, begin, end) ? OddLine() : OddLine{line};
    };
    return parse_pieces<OddLine>(static_cast<std::size_t>(last - first), input_.parallel, parse).at == nullptr;
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

/// Reads rows [begin, end), which lie in the piece from `line` on, each by read(parser). False: a row is malformed, or not
/// alone on its line.
template <class Read>
bool LineReader::read_lines(std::size_t index, const char* line, std::uint64_t begin, std::uint64_t end,
                            const PlyElement& element, Read read) {
    const TextPiece& piece = pieces_[index];
    for (std::uint64_t row = begin; row < end; ++row) {
        const char* const stop = line_end(line, piece.end());
        PlyRows<AsciiNumbers> parser(AsciiNumbers(line, stop), element, row);
        if (stop - line > longest_line || !read(parser)) {
            return false;
        }
        if (!AsciiNumbers(parser.numbers()).at_end()) {
            if (!takes_long_rows_) {
                return false;
            }
            LeftOut& own = faces_[index].long_rows;
            own = {own.count + 1, own.first == nullptr ? line : std::min(own.first, line)};
        }
        line = stop != piece.end() ? stop + 1 : stop;
    }
    return true;
}

template <class Value>
bool LineReader::read_vertices(const RowRange& rows) {
    return for_pieces(rows, [&](std::size_t piece, const char* line, std::uint64_t begin, std::uint64_t end) {
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
    return for_pieces(rows, [&](std::size_t piece, const char* line, std::uint64_t begin, std::uint64_t end) {
        PieceFaces& own = faces_[piece];
        PlyTriangles triangles(vertices, mesh_.indices.span().subspan(3 * own.triangles.first, 3 * own.most_triangles));
        std::vector<std::uint32_t> list;
        const bool good = read_lines(piece, line, begin, end, *rows.element, [&](PlyRows<AsciiNumbers>& parser) {
            return parser.indices(mesh_.vertex_count, list) && triangles.add_face(list);
        });
        own.triangles.count = triangles.index_count() / 3;
        own.small_faces = triangles.small_faces();
        return good;
    });
}

bool LineReader::read_over(const RowRange& rows) {
    return for_pieces(rows, [&](std::size_t piece, const char* line, std::uint64_t begin, std::uint64_t end) {
        PlyLists lists;
        return read_lines(piece, line, begin, end, *rows.element,
                          [&lists](PlyRows<AsciiNumbers>& parser) { return parser.skip(lists); });
    });
}

/// Joins the triangles of all pieces, which may have had more room.
void LineReader::join_triangles() {
    std::vector<ItemRun> runs;
    for (const PieceFaces& own : faces_) {
        runs.push_back(own.triangles);
        mesh_.small_faces += own.small_faces;
        mesh_.long_rows.add(own.long_rows);
    }
    constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t);
    mesh_.indices.set_size(3 * close_gaps(runs, triangle_bytes, reinterpret_cast<std::byte*>(mesh_.indices.data())));
}

bool read_lines_of(const PlyInput& input, bool takes_long_rows, PlyMesh& mesh) {
    PlyMesh attempt(mesh.indices.memory());
    if (!LineReader(input, takes_long_rows, attempt).read()) {
        return false;
    }
    mesh = std::move(attempt);
    return true;
}

}  // namespace

bool read_ply_lines(const PlyInput& input, PlyMesh& mesh) {
    return read_lines_of(input, false, mesh);
}

bool read_ply_long_lines(const PlyInput& input, PlyMesh& mesh) {
    return read_lines_of(input, true, mesh);
}

}  // namespace lamella
