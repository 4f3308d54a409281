#include "io/read/ply/ply.hpp"
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
    LineReader(const PlyInput& input, MeshFile& mesh) : input_(input), mesh_(mesh), budget_(input.source) {}

    PlyBody read() {
        cut_into_lines();
        const PlyElement& vertices = *input_.header.element_of(PlyRole::vertices);
        allocate_vertices(vertices.count, number_for(vertices), budget_, input_.source.memory(), mesh_);
        std::vector<FaceList> lists = parse_faces(pieces_.size(), budget_, input_.parallel(),
                                                  [this](std::size_t i, FaceList& faces) { parse(i, faces); });
        give_faces(
            lists, coordinates_of(mesh_), budget_, input_.parallel(),
            [this](std::size_t, const RefusedFace&) { throw TextError{input_.file.data()}; }, mesh_);
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            body_.small_faces += lists[i].small();
            body_.long_rows.add(long_rows_[i]);
        }
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
        long_rows_.resize(pieces_.size());
        input_.parallel().run(pieces_.size(),
                              [this](std::size_t i, int) { pieces_[i].count = count_lines(pieces_[i].text); });
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

    void parse(std::size_t piece, FaceList& faces) {
        const char* line = pieces_[piece].begin();
        const char* const end = pieces_[piece].end();
        std::vector<std::uint32_t> list;
        for (const RowRange& range : ranges_) {
            const std::uint64_t rows_end = std::min<std::uint64_t>(pieces_[piece].end_item(), range.end);
            for (auto row = std::max<std::uint64_t>(pieces_[piece].first, range.begin); row < rows_end; ++row) {
                const char* const stop = line_end(line, end);
                if (stop - line > longest_line) {
                    throw TextError{line};
                }
                PlyRows<AsciiNumbers> own({line, stop}, *range.element, row);
                if (range.element->role == PlyRole::vertices) {
                    own.vertex(mesh_.vertex_type, mesh_.bytes.data() + (row - range.begin) * mesh_.stride);
                } else if (range.element->role == PlyRole::faces) {
                    own.indices(mesh_.vertex_count, list);
                    faces.add(list, 0);
                } else {
                    own.skip();
                }
                if (!AsciiNumbers(own.numbers()).at_end()) {
                    long_rows_[piece].add(line);
                }
                line = stop != end ? stop + 1 : stop;
            }
        }
    }

    const PlyInput& input_;
    MeshFile& mesh_;
    MemoryBudget budget_;
    PlyBody body_;
    std::vector<TextPiece> pieces_;   // of lines, each a row
    std::vector<LeftOut> long_rows_;  // per piece
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
