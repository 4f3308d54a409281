// PLY, ASCII and binary, of either byte order: all that follows the header.
#include "base/words.hpp"
#include "io/read/ply/ply_rows.hpp"

namespace lamella {

namespace {

/// Takes strips that strip_end separates: a b c d e makes a b c, c b d and c d e. Triangles of two equal indices, which join
/// strips, are left out.
void add_strips(std::span<const std::uint32_t> list, FaceList& faces) {
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
            faces.add(triangle, nullptr);
        }
    }
}

const char* after_line(const char* p, const char* end) {
    const void* const found = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
    return found != nullptr ? static_cast<const char*>(found) + 1 : end;
}

/// Words of a text whose rows are lines. Words after a row's are left out.
class LineNumbers : public AsciiNumbers {
public:
    using AsciiNumbers::AsciiNumbers;

    void begin_row(const char* text_end) { end_ = after_line(p_, text_end); }
    /// False: the line has more words.
    bool end_row() {
        const bool ended = at_end();
        p_ = end_;
        return ended;
    }
};

/// Rows of one element that one task reads.
template <class Numbers>
struct RowBlock {
    const PlyElement* element = nullptr;
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    Numbers numbers;    ///< from where it begins
    LeftOut long_rows;  ///< lines with more words than the header declares
};

/// Fills in the vertices and indices of the mesh: finds where blocks of rows begin, and reads them in parallel, faces after
/// the vertices that they are cut by. Nothing depends on threads.
template <class Numbers>
class BodyReader {
public:
    BodyReader(FileContents& file, const PlyHeader& header, MeshFile& mesh) : file_(file), header_(header), mesh_(mesh) {
        mesh_.text = !Numbers::binary;
    }

    /// From number to number. Throws a TextError at the first that is wrong.
    void read(Numbers numbers) {
        try {
            find_blocks(numbers);
        } catch (const TextError&) {
            if (mesh_.stride != 0 || !blocks_.empty()) {
                parse_blocks();  // what is wrong may be before
            }
            throw;
        }
        read_blocks();
    }

    /// One row a line, as nearly everyone writes it; the same throws. False: there are not as many lines as rows.
    bool read_lines() {
        std::string_view text = file_.whole.substr(header_.body);
        while (!text.empty() && is_space(text.back())) {
            text.remove_suffix(1);
        }
        rest_ = text.data() + text.size();
        std::vector<TextPiece> pieces =
            cut_text(text, text_piece_bytes, [this](const char*, const char* from) { return after_line(from, rest_); });
        source_.parallel().run(pieces.size(), [&](std::size_t i, int) {
            const std::string_view own = pieces[i].text;  // the last may lack its end
            pieces[i].count = (own.front() == '\n' ? 1U : 0U) + (own.back() != '\n' ? 1U : 0U) +
                              count_in(own, [](char, char c) { return c == '\n'; });
        });
        const std::uint64_t lines = number_items(pieces);
        std::uint64_t rows = 0;
        for (const PlyElement& element : header_.elements) {
            if (element.count > lines - rows || (element.properties.empty() && element.count > 0)) {
                return false;
            }
            find_blocks(element, rows, pieces);
            rows += element.count;
        }
        if (rows == lines) {
            read_blocks();
        }
        return rows == lines;
    }

private:
    using Block = RowBlock<Numbers>;

    static bool is_faces(const PlyElement& element) {
        return element.role == PlyRole::faces || element.role == PlyRole::strips;
    }
    void add_block(const Block& block) { (is_faces(*block.element) ? face_blocks_ : blocks_).push_back(block); }

    void find_blocks(Numbers& numbers) {
        for (const PlyElement& element : header_.elements) {
            const auto left = static_cast<std::uint64_t>(end() - numbers.at());
            if (std::string what = header_.why_too_many(element, left); !what.empty()) {
                throw TextError{numbers.at(), std::move(what), !Numbers::binary};
            }
            find_blocks(element, numbers);
        }
        rest_ = numbers.at();
    }

    /// Moves past the element. Vertices and triangles that can be copied are no blocks, nor are rows that are not used.
    void find_blocks(const PlyElement& element, Numbers& numbers) {
        const bool fixed = Numbers::binary && !element.has_lists();
        if constexpr (Numbers::binary) {
            const bool copied = element.role == PlyRole::faces && copy_triangles(element, numbers.at());
            const bool in_place = element.role == PlyRole::vertices && has_packed_coordinates(element);
            if (in_place) {
                use_vertices(element, numbers.at());
            }
            if (copied || in_place || (fixed && element.role == PlyRole::nothing)) {
                const std::size_t row = copied ? triangle_row_bytes(element) : element.row_bytes();
                numbers.skip(NumberType::uint8, element.count * row);
                return;
            }
        }
        StopPace pace = pace_of(source_.parallel());
        for (std::uint64_t row = 0; row < element.count && !element.properties.empty(); ++row) {
            const bool begins_block = row % rows_a_block == 0;
            const std::uint64_t block_end = std::min(element.count, row + rows_a_block);
            pace.spend(step_work);
            if (begins_block && element.role != PlyRole::nothing) {
                add_block({&element, row, block_end, numbers, {}});
            }
            if (fixed && begins_block) {
                numbers.skip(NumberType::uint8, (block_end - row) * element.row_bytes());
                row = block_end - 1;
            } else {
                PlyRows<Numbers> skipped(numbers, element, row);
                skipped.skip();
                numbers = skipped.numbers();
            }
        }
    }

    /// The element's rows, each a line of `pieces`, are those from `first` on.
    void find_blocks(const PlyElement& element, std::uint64_t first, const std::vector<TextPiece>& pieces) {
        for (const TextPiece& piece : pieces) {
            const std::uint64_t begin = std::max<std::uint64_t>(piece.first, first);
            const std::uint64_t end = std::min<std::uint64_t>(piece.end_item(), first + element.count);
            const char* line = piece.begin();
            for (std::uint64_t row = piece.first; row < begin && begin < end; ++row) {
                line = after_line(line, piece.end());
            }
            if (begin < end) {
                add_block({&element, begin - first, end - first, Numbers(line, piece.end()), {}});
            }
        }
    }

    void read_blocks() {
        std::vector<FaceList> lists = parse_blocks();
        if (mesh_.triangle_count == 0) {
            give_faces(lists, budget_, source_, file_.whole, mesh_);
        }
        describe();
    }

    std::vector<FaceList> parse_blocks() {
        if (vertices_.count >= most_vertices) {
            throw TextError{vertices_.at, "more vertices than can be numbered"};
        }
        if (mesh_.stride == 0) {
            allocate_vertices(vertices_.count, number_for(vertices_), budget_, source_.memory(), mesh_);
            for (const PlyProperty& property : vertices_.properties) {
                if (property.use == PlyUse::scalar) {
                    budget_.take(vertices_.count, sizeof(double));
                    mesh_.scalars.push_back(
                        {std::string(property.name), 1, is_integer(property.type), Array<double>(source_.memory())});
                    mesh_.scalars.back().values.resize_discarding(vertices_.count);
                }
            }
        }
        parse_pieces(blocks_.size(), source_.parallel(), [&](std::size_t i, int) {
            FaceList none(budget_, {}, source_.memory());
            read_block(blocks_[i], none);
        });
        return parse_faces(face_blocks_.size(), coordinates_of(mesh_), budget_, source_.parallel(),
                           [&](std::size_t i, FaceList& faces) { read_block(face_blocks_[i], faces); });
    }

    void read_block(Block& block, FaceList& faces) {
        StopPace pace = pace_of(source_.parallel());
        std::vector<std::uint32_t> corners;
        Numbers numbers = block.numbers;
        const char* const block_end = numbers.end();
        for (std::uint64_t row = block.begin; row < block.end; ++row) {
            pace.spend(step_work * (1 + corners.size()));
            const char* const place = numbers.at();
            numbers.begin_row(block_end);
            numbers = read_row(numbers, *block.element, row, corners, faces);
            if (!numbers.end_row()) {
                block.long_rows.add(place);
            }
        }
    }

    /// Returns where the next row begins. By value, so that it is kept in registers.
    Numbers read_row(Numbers numbers, const PlyElement& element, std::uint64_t row, std::vector<std::uint32_t>& corners,
                     FaceList& faces) {
        const char* const place = numbers.at();
        PlyRows<Numbers> rows(numbers, element, row);
        if (element.role == PlyRole::vertices) {
            rows.vertex(mesh_.vertex_type, mesh_.bytes.data() + row * mesh_.stride, mesh_.scalars);
        } else if (element.role == PlyRole::nothing) {
            rows.skip();
        } else {
            rows.indices(vertices_.count, corners);
            element.role == PlyRole::faces ? faces.add(corners, place, mesh_.text) : add_strips(corners, faces);
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
            vertices_.count > most_ply_vertices || header_.element_of(PlyRole::strips) != nullptr ||
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
                                        vertices_.count, mesh_.indices.data() + 3 * row)) {
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

    void describe() {
        rest_ = mesh_.text ? skip_space(rest_, end()) : rest_;
        header_.describe(source_, file_.whole, mesh_);
        LeftOut longer;
        for (const std::vector<Block>* const blocks : {&blocks_, &face_blocks_}) {
            std::for_each(blocks->begin(), blocks->end(), [&](const Block& block) { longer.add(block.long_rows); });
        }
        if (longer.count > 0) {
            mesh_.warnings.push_back(source_.name() + ": ignored what follows the declared properties in " +
                                     counted(longer.count, "line") + first_line_words(longer, file_.whole));
        }
        warn_of_rest(source_, static_cast<std::uint64_t>(end() - rest_), mesh_);
    }

    const char* end() const { return file_.whole.data() + file_.whole.size(); }

    static constexpr std::uint64_t rows_a_block = std::uint64_t{1} << 16;

    FileContents& file_;
    const FileSource& source_ = file_.source;
    const PlyHeader& header_;
    MeshFile& mesh_;
    MemoryBudget budget_{source_};
    const PlyElement& vertices_ = *header_.element_of(PlyRole::vertices);
    const char* rest_ = nullptr;      // after the last element
    std::vector<Block> blocks_;       // of vertices, and of lines that are not used
    std::vector<Block> face_blocks_;  // of faces that are not copied
};

}  // namespace

void parse_ply(FileContents& file, MeshFile& mesh) {
    const PlyHeader header = parse_ply_header(file.source, file.whole);
    const char* const begin = file.whole.data() + header.body;
    const char* const end = file.whole.data() + file.whole.size();
    if (header.encoding != PlyEncoding::ascii) {
        return BodyReader<BinaryNumbers>(file, header, mesh).read({begin, end, header.swapped()});
    }
    try {
        // First, as from number to number words that no property takes would be read as the next row.
        if (BodyReader<LineNumbers>(file, header, mesh).read_lines()) {
            return;
        }
    } catch (const TextError&) {
        mesh = MeshFile();
    }
    BodyReader<AsciiNumbers>(file, header, mesh).read({begin, end});
}

}  // namespace lamella
