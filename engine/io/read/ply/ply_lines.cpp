#include "io/read/ply/ply_body.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

/// Longer lines are left to the other reader, so that no thread needs much memory for a list.
constexpr std::ptrdiff_t longest_line = std::ptrdiff_t{16} << 10;

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

/// A line that is not as usual ends it by a TextError without words: the reader that goes from number to number says what is
/// wrong there, if anything is.
class LineReader {
public:
    LineReader(const PlyInput& input, MeshFile& mesh) : input_(input), mesh_(mesh) {}

    PlyBody read() {
        cut_into_lines();
        allocate();
        parse_pieces(pieces_.size(), input_.parallel(), [this](std::size_t i, int) { parse(i); });
        cut_faces(faces_, mesh_.indices.span(), {mesh_.bytes.data(), mesh_.stride, mesh_.vertex_type}, input_.parallel(),
                  [this](std::size_t, const RefusedFace&) { throw TextError{input_.file.data()}; });
        std::vector<ItemRun> runs;
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            runs.push_back({faces_[i].first_triangle, faces_[i].triangles});
            body_.small_faces += faces_[i].small.count;
            body_.long_rows.add(long_rows_[i]);
        }
        constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t);
        mesh_.triangle_count = close_gaps(runs, triangle_bytes, reinterpret_cast<std::byte*>(mesh_.indices.data()));
        mesh_.indices.set_size(3 * mesh_.triangle_count);
        return body_;
    }

private:
    /// The body must have as many lines as rows.
    void cut_into_lines() {
        std::string_view text = input_.file.substr(input_.header.body);
        while (!text.empty() && is_space(text.back())) {
            text.remove_suffix(1);
        }
        body_.end = input_.header.body + text.size();
        pieces_ = cut_after_newlines(text);
        words_.resize(pieces_.size());
        faces_.resize(pieces_.size());
        long_rows_.resize(pieces_.size());
        input_.parallel().run(pieces_.size(), [this](std::size_t i, int) {
            pieces_[i].count = count_lines(pieces_[i].text);
            words_[i] = count_words(pieces_[i].text);
        });
        const std::uint64_t lines = number_items(pieces_);
        std::uint64_t rows = 0;
        for (const PlyElement& element : input_.header.elements) {
            const bool takes_no_line = element.properties.empty() && element.count > 0;
            if (element.count > lines - rows || takes_no_line || element.role == PlyRole::strips) {
                throw TextError{text.data()};
            }
            ranges_.push_back({&element, rows, rows + element.count});
            rows += element.count;
        }
        if (rows != lines) {
            throw TextError{text.data()};
        }
    }

    /// Makes room for the triangles of each piece: a row of n corners has n - 2 of them and, beside the corners, its length
    /// and other properties. Faces of fewer corners than three may make this too little; the other reader takes over then.
    void allocate() {
        const PlyElement& vertices = *input_.header.element_of(PlyRole::vertices);
        std::size_t triangles = 0;
        for (const RowRange& range : ranges_) {
            const std::uint64_t words_beside = 2 + range.element->properties.size();
            for (std::size_t i = 0; range.element->role == PlyRole::faces && i < pieces_.size(); ++i) {
                if (first_row(i, range) < end_row(i, range)) {
                    const std::uint64_t count = end_row(i, range) - first_row(i, range);
                    faces_[i].first_triangle = triangles;
                    faces_[i].triangles = std::max(count, words_[i] - std::min(words_[i], count * words_beside));
                    triangles += faces_[i].triangles;
                }
            }
        }
        const Number type = number_for(vertices);
        const std::uint64_t bytes = vertices.count * 3 * size_of(type) + triangles * 3 * sizeof(std::uint32_t);
        if (vertices.count > strip_end || bytes > input_.source.memory_limit()) {
            throw TextError{input_.file.data()};
        }
        allocate_vertices(vertices.count, type, input_.source.memory(), mesh_);
        mesh_.indices = Array<std::uint32_t>(input_.source.memory());
        mesh_.indices.resize_discarding(3 * triangles);
    }

    void parse(std::size_t piece) {
        const char* line = pieces_[piece].begin();
        for (const RowRange& range : ranges_) {
            if (range.element->role == PlyRole::vertices) {
                line = vertices(piece, range, line);
            } else if (range.element->role == PlyRole::faces) {
                line = faces(piece, range, line);
            } else {
                PlyLists lists;
                line = rows(piece, range, line, [&lists](PlyRows<AsciiNumbers>& row) { row.skip(lists); });
            }
        }
    }

    /// Reads those rows of the range that lie in the piece, from `line` on, each by read(row). Returns where the next line
    /// begins.
    template <class Read>
    const char* rows(std::size_t piece, const RowRange& range, const char* line, Read read) {
        const char* const end = pieces_[piece].end();
        for (std::uint64_t number = first_row(piece, range); number < end_row(piece, range); ++number) {
            const char* const stop = line_end(line, end);
            PlyRows<AsciiNumbers> row(AsciiNumbers(line, stop), *range.element, number);
            if (stop - line > longest_line) {
                throw TextError{line};
            }
            read(row);
            if (!AsciiNumbers(row.numbers()).at_end()) {
                long_rows_[piece].add(line);
            }
            line = stop != end ? stop + 1 : stop;
        }
        return line;
    }

    const char* vertices(std::size_t piece, const RowRange& range, const char* line) {
        std::byte* out = mesh_.bytes.data() + (first_row(piece, range) - range.begin) * mesh_.stride;
        return rows(piece, range, line, [this, &out](PlyRows<AsciiNumbers>& row) {
            row.vertex(mesh_.vertex_type, out);
            out += mesh_.stride;
        });
    }

    const char* faces(std::size_t piece, const RowRange& range, const char* line) {
        FaceRange& own = faces_[piece];
        FaceWriter writer(mesh_.indices.span(), own);
        std::vector<std::uint32_t> list;
        line = rows(piece, range, line, [&](PlyRows<AsciiNumbers>& row) {
            row.indices(mesh_.vertex_count, list);
            if (!writer.add(list)) {
                throw TextError{row.numbers().at()};
            }
            own.small.count += list.size() < 3 ? 1 : 0;
        });
        own.triangles = writer.triangles();
        return line;
    }

    std::uint64_t first_row(std::size_t piece, const RowRange& range) const {
        return std::max<std::uint64_t>(pieces_[piece].first, range.begin);
    }
    std::uint64_t end_row(std::size_t piece, const RowRange& range) const {
        return std::min<std::uint64_t>(pieces_[piece].end_item(), range.end);
    }

    const PlyInput& input_;
    MeshFile& mesh_;
    PlyBody body_;
    std::vector<TextPiece> pieces_;     // of lines, each a row
    std::vector<std::uint64_t> words_;  // per piece
    std::vector<FaceRange> faces_;      // per piece
    std::vector<LeftOut> long_rows_;    // per piece
    std::vector<RowRange> ranges_;
};

}  // namespace

bool read_ply_lines(const PlyInput& input, MeshFile& mesh, PlyBody& body) {
    try {
        body = LineReader(input, mesh).read();
        return true;
    } catch (const TextError&) {
        mesh = MeshFile();
        return false;
    }
}

}  // namespace lamella
