// PLY, ASCII and binary, of either byte order: all that follows the header.
#include "base/words.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

/// Takes strips that strip_end separates: a b c d e makes a b c, c b d and c d e. Triangles of two equal indices, which join
/// strips, are left out.
void add_strips(std::span<const std::uint32_t> list, std::size_t place, FaceList& faces) {
    std::size_t begin = 0;  // of the strip
    for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i] == strip_end) {
            begin = i + 1;
        }
        if (i < begin + 2) {
            continue;
        }
        // Every other triangle of a strip is listed in reverse.
        const bool odd = (i - begin) % 2 != 0;
        const std::uint32_t triangle[] = {list[odd ? i - 1 : i - 2], list[odd ? i - 2 : i - 1], list[i]};
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) {
            faces.add(triangle, place);
        }
    }
}

const char* after_line(const char* p, const char* end) {
    const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
    return found != nullptr ? static_cast<const char*>(found) + 1 : end;
}

/// The rows of one element, counted over the whole body.
struct RowRange {
    const PlyElement* element = nullptr;
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
};

/// Fills in the vertices and indices of the mesh, in one of two ways.
class BodyReader {
public:
    BodyReader(FileContents& file, const PlyHeader& header, MeshFile& mesh)
        : file_(file),
          source_(file.source),
          header_(header),
          mesh_(mesh),
          budget_(file.source),
          vertex_count_(header.element_of(PlyRole::vertices)->count) {}

    /// From number to number, on one thread. Throws the first error in the body.
    void read_numbers() {
        if (header_.encoding == PlyEncoding::ascii) {
            read_elements(AsciiNumbers(begin(), end()));
        } else {
            read_elements(BinaryNumbers(begin(), end(), header_.swapped()));
        }
        finish();
    }

    /// In parallel: ASCII as nearly everyone writes it, one row a line. Lines may have more words than the header declares,
    /// which are ignored and counted. False: there are not as many lines as rows. Throws a TextError where something is
    /// wrong, by lines, and then read_numbers() may succeed. Neither depends on threads.
    bool read_lines() {
        if (!cut_into_lines()) {
            return false;
        }
        const PlyElement& vertices = *header_.element_of(PlyRole::vertices);
        allocate_vertices(vertices.count, number_for(vertices), budget_, source_.memory(), mesh_);
        lists_ = parse_faces(pieces_.size(), budget_, source_.parallel(),
                             [this](std::size_t i, FaceList& faces) { parse_lines(i, faces); });
        give(true);
        finish();
        return true;
    }

private:
    template <class Numbers>
    void read_elements(Numbers numbers) {
        const char* vertices = nullptr;
        for (const PlyElement& element : header_.elements) {
            const auto left = static_cast<std::uint64_t>(end() - numbers.at());
            if (std::string what = header_.why_too_many(element, left); !what.empty()) {
                throw TextError{numbers.at(), std::move(what), !Numbers::binary};
            }
            if (element.role == PlyRole::vertices) {
                vertices = numbers.at();
                if (element.count >= most_vertices) {
                    throw TextError{element.at, "more vertices than can be numbered"};
                }
            }
            if (!pass_over(element, numbers)) {
                read_rows(element, numbers);
            }
        }
        rest_ = numbers.at();
        if (mesh_.stride == 0) {
            use_vertices(*header_.element_of(PlyRole::vertices), vertices);
        }
        if (!lists_.empty()) {
            give(!Numbers::binary);
        }
    }

    /// True if rows need not be read one by one: they are skipped, or triangles that can be copied as nearly all are.
    bool pass_over(const PlyElement& element, AsciiNumbers& /*numbers*/) { return element.properties.empty(); }
    bool pass_over(const PlyElement& element, BinaryNumbers& numbers) {
        const bool fixed = element.role == PlyRole::vertices ? has_packed_coordinates(element) : !element.has_lists();
        const bool copied = element.role == PlyRole::faces && copy_triangles(element, numbers.at());
        const std::size_t row = copied ? triangle_row_bytes(element) : element.row_bytes();
        return (fixed || copied) && numbers.skip(NumberType::uint8, element.count * row);
    }

    template <class Numbers>
    void read_rows(const PlyElement& element, Numbers& numbers) {
        constexpr std::uint64_t rows_a_list = std::uint64_t{1} << 16;
        if (element.role == PlyRole::vertices) {
            allocate_vertices(element.count, number_for(element), budget_, source_.memory(), mesh_);
        }
        const bool is_faces = element.role == PlyRole::faces || element.role == PlyRole::strips;
        FaceList none(budget_, source_.memory());
        Lookout lookout(source_.parallel());
        std::vector<std::uint32_t> corners;
        if constexpr (Numbers::binary) {
            if (element.role == PlyRole::vertices && !element.has_lists()) {  // rows of one size
                source_.parallel().run_ranges(element.count, rows_a_list, [&](std::size_t first, std::size_t last, int) {
                    Numbers own = numbers;
                    own.skip(NumberType::uint8, first * element.row_bytes());
                    for (std::size_t row = first; row < last; ++row) {
                        own = read_row(own, element, row, corners, none);
                    }
                });
                numbers.skip(NumberType::uint8, element.count * element.row_bytes());
                return;
            }
        }
        for (std::uint64_t row = 0; row < element.count; ++row) {
            lookout.pass(1 + corners.size());
            if (row % rows_a_list == 0 && is_faces) {
                lists_.emplace_back(budget_, source_.memory());
            }
            numbers = read_row(numbers, element, row, corners, is_faces ? lists_.back() : none);
        }
    }

    /// Returns where the next row begins. By value, so that it is kept in registers.
    template <class Numbers>
    Numbers read_row(Numbers numbers, const PlyElement& element, std::uint64_t row, std::vector<std::uint32_t>& corners,
                     FaceList& faces) {
        const auto place = static_cast<std::size_t>(numbers.at() - file_.whole.data());
        PlyRows<Numbers> rows(numbers, element, row);
        if (element.role == PlyRole::vertices) {
            rows.vertex(mesh_.vertex_type, mesh_.bytes.data() + row * mesh_.stride);
        } else if (element.role == PlyRole::nothing) {
            rows.skip();
        } else {
            rows.indices(vertex_count_, corners);
            element.role == PlyRole::faces ? faces.add(corners, place) : add_strips(corners, place, faces);
        }
        return rows.numbers();
    }

    /// Copies the indices of rows that are all triangles. False: others are among them or come later, an index is no
    /// vertex, or memory does not suffice.
    bool copy_triangles(const PlyElement& faces, const char* rows) {
        constexpr std::size_t grain = std::size_t{1} << 14;
        constexpr std::size_t triangle_bytes = 3 * sizeof(std::uint32_t);
        const std::size_t stride = triangle_row_bytes(faces);
        if (stride == 0 || faces.count > static_cast<std::uint64_t>(end() - rows) / stride ||
            vertex_count_ > most_ply_vertices || header_.element_of(PlyRole::strips) != nullptr ||
            !budget_.try_take(faces.count, triangle_bytes)) {
            return false;
        }
        mesh_.indices = Array<std::uint32_t>(source_.memory());
        mesh_.indices.resize_discarding(3 * faces.count);
        std::atomic<bool> good{true};
        source_.parallel().run_ranges(faces.count, grain, [&](std::size_t first, std::size_t last, int) {
            constexpr std::size_t in_cache = 512;
            for (std::size_t row = first; row < last && good.load(std::memory_order_relaxed); row += in_cache) {
                if (!copy_triangle_rows(faces, header_.swapped(), rows + row * stride, std::min(in_cache, last - row),
                                        vertex_count_, mesh_.indices.data() + 3 * row)) {
                    good.store(false, std::memory_order_relaxed);
                }
            }
        });
        if (good) {
            mesh_.triangle_count = faces.count;
        } else {
            mesh_.indices = Array<std::uint32_t>();
            budget_.give_back(faces.count * triangle_bytes);
        }
        return good;
    }

    /// Vertices of a binary file stay where they lie, in the machine's byte order.
    void use_vertices(const PlyElement& element, const char* rows) {
        constexpr std::size_t grain = std::size_t{1} << 14;
        mesh_.first_offset = static_cast<std::size_t>(rows - file_.whole.data()) + element.row_bytes(PlyUse::x);
        mesh_.stride = element.row_bytes();
        mesh_.vertex_type = number_for(element);
        mesh_.vertex_count = element.count;
        mesh_.bytes = std::move(file_.bytes);
        if (header_.swapped()) {
            source_.parallel().run_ranges(element.count, grain, [&](std::size_t first, std::size_t last, int) {
                std::byte* const own = mesh_.bytes.data() + mesh_.first_offset + first * mesh_.stride;
                copy_coordinates(mesh_.vertex_type, true, own, mesh_.stride, last - first, own, mesh_.stride);
            });
        }
    }

    // --- by lines

    /// The body must have as many lines as rows.
    bool cut_into_lines() {
        std::string_view text = file_.whole.substr(header_.body);
        while (!text.empty() && is_space(text.back())) {
            text.remove_suffix(1);
        }
        rest_ = text.data() + text.size();
        pieces_ =
            cut_text(text, text_piece_bytes, [this](const char*, const char* from) { return after_line(from, rest_); });
        long_rows_.resize(pieces_.size());
        source_.parallel().run(pieces_.size(), [this](std::size_t i, int) {
            const std::string_view own = pieces_[i].text;  // the last may lack its end
            pieces_[i].count = (own.front() == '\n' ? 1U : 0U) + (own.back() != '\n' ? 1U : 0U) +
                               count_in(own, [](char, char c) { return c == '\n'; });
        });
        const std::uint64_t lines = number_items(pieces_);
        std::uint64_t rows = 0;
        for (const PlyElement& element : header_.elements) {
            if (element.count > lines - rows || (element.properties.empty() && element.count > 0)) {
                return false;
            }
            ranges_.push_back({&element, rows, rows + element.count});
            rows += element.count;
        }
        return rows == lines;
    }

    void parse_lines(std::size_t piece, FaceList& faces) {
        const char* line = pieces_[piece].begin();
        std::vector<std::uint32_t> corners;
        for (const RowRange& range : ranges_) {
            const std::uint64_t rows_end = std::min<std::uint64_t>(pieces_[piece].end_item(), range.end);
            for (auto row = std::max<std::uint64_t>(pieces_[piece].first, range.begin); row < rows_end; ++row) {
                const char* const next = after_line(line, pieces_[piece].end());
                AsciiNumbers rest = read_row(AsciiNumbers(line, next), *range.element, row - range.begin, corners, faces);
                if (!rest.at_end()) {
                    long_rows_[piece].add(line);
                }
                line = next;
            }
        }
    }

    // ---

    /// Gives the mesh the triangles of all lists.
    void give(bool has_lines) {
        give_faces(
            lists_, coordinates_of(mesh_), budget_, source_.parallel(),
            [&](std::size_t, std::uint64_t place, std::string what) {
                return TextError{file_.whole.data() + place, std::move(what), has_lines};
            },
            mesh_);
    }

    void finish() {
        if (mesh_.triangle_count == 0) {
            source_.refuse(ErrorCode::empty_mesh, "holds no triangles");
        }
        mesh_.text = header_.encoding == PlyEncoding::ascii;
        rest_ = mesh_.text ? skip_space(rest_, end()) : rest_;
        header_.describe(source_, file_.whole, mesh_);
        LeftOut longer;
        std::for_each(long_rows_.begin(), long_rows_.end(), [&](const LeftOut& rows) { longer.add(rows); });
        if (longer.count > 0) {
            mesh_.warnings.push_back(source_.name() + ": ignored what follows the declared properties in " +
                                     counted(longer.count, "line") + first_line_words(longer, file_.whole));
        }
        std::uint64_t small = 0;
        std::for_each(lists_.begin(), lists_.end(), [&](const FaceList& list) { small += list.small(); });
        if (small > 0) {
            mesh_.warnings.push_back(source_.name() + ": left out " + counted(small, "face") +
                                     " of fewer than three vertices");
        }
        warn_of_rest(source_, static_cast<std::uint64_t>(end() - rest_), mesh_);
    }

    const char* begin() const { return file_.whole.data() + header_.body; }
    const char* end() const { return file_.whole.data() + file_.whole.size(); }

    FileContents& file_;
    const FileSource& source_;
    const PlyHeader& header_;
    MeshFile& mesh_;
    MemoryBudget budget_;
    std::uint64_t vertex_count_;
    const char* rest_ = nullptr;      // after the last element
    std::vector<FaceList> lists_;     // of faces that are not copied
    std::vector<TextPiece> pieces_;   // of lines, each a row
    std::vector<LeftOut> long_rows_;  // per piece
    std::vector<RowRange> ranges_;
};

void parse_ply(FileContents& file, MeshFile& mesh) {
    const PlyHeader header = parse_ply_header(file.source, file.whole);
    try {
        // First, as from number to number words that no property takes would be read as the next row.
        if (header.encoding == PlyEncoding::ascii && BodyReader(file, header, mesh).read_lines()) {
            return;
        }
    } catch (const TextError&) {
        mesh = MeshFile();
    }
    BodyReader(file, header, mesh).read_numbers();
}

}  // namespace

MeshFile read_ply(FileSource& source) {
    return read_contents(source, parse_ply);
}

}  // namespace lamella
