// OFF, as text: a header, two counts, then a line for each vertex and for each face. Files whose lines end elsewhere are
// read number by number, on one thread.
//
//     [ST][C][N]OFF                 may be left out where the file's name says what it is
//     VERTICES FACES [EDGES]        on lines of their own or on the header's
//     X Y Z ...                     for each vertex; normal, colour and texture are skipped
//     CORNERS V V V ... [COLOUR]    for each face, with vertices numbered from 0

#include "base/words.hpp"
#include "io/read/faces.hpp"
#include "io/read/stated.hpp"

namespace lamella {

namespace {

/// The header's word, or nothing.
std::string_view header_word(std::string_view text) {
    const char* const begin = text.data() + head_comments(text).size();
    const char* const end = text.data() + text.size();
    const std::string_view word(begin, static_cast<std::size_t>(skip_word(begin, end) - begin));
    const bool is_header = word.ends_with("OFF") && word.size() <= std::string_view("STCN4nOFF").size() &&
                           word.find_first_not_of("STCN4nOF") == std::string_view::npos;
    return is_header ? word : std::string_view();
}

/// All before the counts: comments and the header's word.
std::string_view head_of(std::string_view text) {
    const std::string_view word = header_word(text);
    const std::size_t begin = word.empty() ? 0 : static_cast<std::size_t>(word.data() + word.size() - text.data());
    return text.substr(0, begin + head_comments(text.substr(begin)).size());
}

struct OffCounts {
    std::size_t vertices = 0;
    std::size_t faces = 0;
    const char* at = nullptr;

    std::size_t items() const { return vertices + faces; }
    std::string words() const { return counted(vertices, "vertex", "vertices") + " and " + counted(faces, "face"); }
    /// True if `bytes` can hold as many numbers. The shortest are "0 0 0" of a vertex and "0" of a face without corners,
    /// each number with a space after it; the last may lack it.
    bool fit(std::size_t bytes) const { return 6 * vertices + 2 * faces <= bytes + 1; }
};

/// How vertices and faces, the items of a file, are told apart.
enum class OffLayout : std::uint8_t {
    lines,         ///< each has a line of its own
    numbers,       ///< lines end anywhere, but with what follows coordinates and corners: as much for every face
    bare_numbers,  ///< nothing follows coordinates and corners, and the number of edges is not left out
};

/// Reads items one after the other.
class OffParser : private LineParser {
public:
    OffParser(std::string_view text, OffLayout layout, const Parallel& parallel)
        : LineParser(text), layout_(layout), pace_(pace_of(parallel)) {}

    /// Reads the file's head, which rest() then follows. The number of edges may be absent: it is on the line of the faces'.
    OffCounts header() {
        const std::string_view text(p_, static_cast<std::size_t>(end_ - p_));
        const std::string_view word = header_word(text);
        if (word.find_first_of("4n") != std::string_view::npos) {
            p_ = word.data();
            fail("vertices of other than three coordinates are not read: " + found());
        }
        if (layout_ == OffLayout::bare_numbers && word.find_first_of("STCN") != std::string_view::npos) {
            fail("numbers beside coordinates and corners");
        }
        p_ += head_of(text).size();
        OffCounts counts;
        counts.at = p_;
        counts.vertices = whole_number("the number of vertices");
        next_word();
        counts.faces = whole_number("the number of faces");
        if (layout_ == OffLayout::bare_numbers) {
            whole_number("the number of edges");
            return counts;
        }
        if (to_word()) {
            whole_number("the number of edges");
        }
        other_numbers(0);
        return counts;
    }

    const char* rest() const { return p_; }

    /// Reads items [first, last), vertices to `coordinates` and faces to `faces`.
    void items(std::size_t first, std::size_t last, const OffCounts& counts, std::byte* coordinates, FaceList& faces) {
        for (std::size_t item = first; item < last; ++item) {
            next_word();
            item_ = p_;
            if (item < counts.vertices) {
                vertex_item(coordinates + item * 3 * sizeof(double));
            } else {
                face_item(counts.vertices);
                faces.add(corners_, item_);
            }
            if (layout_ == OffLayout::lines) {
                p_ = skip_line(p_, end_);
            }
        }
    }

    /// Where the last item begins.
    const char* item() const { return item_; }

    /// Where nothing tells what else may follow the last item, nothing may.
    void end() {
        if (layout_ == OffLayout::bare_numbers && next_word()) {
            fail("expected the end of the file");
        }
    }

    /// The number of lines with items, which are not parsed.
    std::size_t count_lines() {
        std::size_t lines = 0;
        for (; next_word(); ++lines) {
            p_ = skip_line(p_, end_);
        }
        return lines;
    }

private:
    /// To the next word of the item.
    bool to_number() {
        if (layout_ == OffLayout::lines) {
            return to_word();
        }
        pace_.spend(step_work);
        return next_word();
    }

    std::size_t whole_number(const char* what) {
        constexpr std::uint64_t limit =
            std::min<std::uint64_t>(std::uint64_t{1} << 53, std::numeric_limits<std::size_t>::max());
        std::uint64_t number = 0;
        const bool found_word = to_number();
        const char* const begin = p_;
        p_ = read_digits(begin, end_, number);
        if (!found_word || p_ == begin || !word_ends(p_)) {
            p_ = begin;
            fail(std::string("expected ") + what + ", found " + found());
        }
        return static_cast<std::size_t>(std::min(number, limit));
    }

    std::uint32_t vertex_number(std::size_t vertex_count) {
        const char* const begin = p_;
        const std::size_t number = whole_number("a vertex number");
        if (number >= vertex_count) {
            p_ = begin;
            fail("vertex number out of range: the file has " + counted(vertex_count, "vertex", "vertices") + ", found " +
                 found());
        }
        return static_cast<std::uint32_t>(number);
    }

    void vertex_item(std::byte* to) {
        constexpr int normal_colour_and_texture = 3 + 4 + 2;
        double xyz[3];
        for (double& value : xyz) {
            to_number();
            value = coordinate();
        }
        std::memcpy(to, xyz, sizeof xyz);
        extras(normal_colour_and_texture);
    }

    void face_item(std::size_t vertex_count) {
        constexpr int colour = 4;
        const std::size_t corners = whole_number("the number of a face's corners");
        corners_.clear();
        for (std::size_t i = 0; i < corners; ++i) {
            const bool ended = !to_number();
            if (ended && layout_ == OffLayout::lines && corners > static_cast<std::size_t>(p_ - item_) / 2) {
                p_ = item_;
                fail("the face counts " + std::to_string(corners) + " corners, more than its line holds");
            }
            corners_.push_back(vertex_number(vertex_count));
        }
        const int count = extras(colour);
        if (layout_ == OffLayout::numbers && face_extras_.value_or(count) != count) {
            p_ = item_;
            fail("expected as many numbers after the corners as in the faces before");
        }
        face_extras_ = count;
    }

    int extras(int most) { return layout_ == OffLayout::bare_numbers ? 0 : other_numbers(most); }

    OffLayout layout_;
    StopPace pace_;
    const char* item_ = nullptr;
    std::optional<int> face_extras_;      // of the first face
    std::vector<std::uint32_t> corners_;  // of a face
};

/// Each vertex and each face on a line of its own. Lines after the last are left out with a warning.
void read_lines(const FileContents& file, MeshFile& mesh) {
    const Parallel& parallel = file.source.parallel();
    OffParser head(file.text, OffLayout::lines, parallel);
    const OffCounts counts = head.header();
    const std::string_view body = file.text.substr(static_cast<std::size_t>(head.rest() - file.text.data()));
    if (!counts.fit(body.size())) {
        throw TextError{counts.at, "counts " + counts.words() + ", more than the " + std::to_string(body.size()) +
                                       " bytes that follow can hold"};
    }
    std::vector<TextPiece> pieces = cut_at_lines(body);
    const auto parser = [&](std::size_t i) { return OffParser(pieces[i].text, OffLayout::lines, parallel); };
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].count = parser(i).count_lines(); });
    const std::size_t lines = number_items(pieces);
    const auto parse = [&](std::size_t i, std::byte* coordinates, FaceList& faces) {
        const std::size_t last = std::min(pieces[i].end_item(), counts.items());
        parser(i).items(pieces[i].first, last, counts, coordinates, faces);
        if (i + 1 == pieces.size() && lines < counts.items()) {
            throw TextError{body.data() + body.size(), "expected " + counts.words() + ", found the end of the file"};
        }
    };
    read_faces(file, std::min(counts.vertices, lines), pieces.size(), parse, mesh);
    if (lines > counts.items()) {
        mesh.warnings.push_back(file.source.name() + ": ignored " + counted(lines - counts.items(), "line") +
                                " after the last of " + counted(counts.faces, "face"));
    }
}

// --- number by number

/// A file that is no lines of one vertex or face each, for which it was `refused`. That is the error too, unless the file
/// ends too early and all before is right.
void read_numbers(const FileContents& file, const TextError& refused, MeshFile& mesh) {
    const FileSource& source = file.source;
    const char* const end = file.text.data() + file.text.size();
    std::optional<TextError> cut_off;
    for (const OffLayout layout : {OffLayout::numbers, OffLayout::bare_numbers}) {
        OffParser parser(file.text, layout, source.parallel());
        try {
            const OffCounts counts = parser.header();
            if (!counts.fit(static_cast<std::size_t>(end - parser.rest()))) {
                continue;
            }
            const auto parse = [&](std::size_t, std::byte* coordinates, FaceList& faces) {
                parser.items(0, counts.items(), counts, coordinates, faces);
                parser.end();
            };
            read_faces(file, counts.vertices, 1, parse, mesh);
        } catch (const TextError& error) {
            if (!cut_off && error.at == end && parser.item() != nullptr && parser.item() > refused.at) {
                cut_off = error;
            }
            continue;
        }
        mesh.warnings.push_back(source.name() + ": was read number by number, as it is not one vertex or one face a line (" +
                                source.error_in_text(file.whole, refused).message.substr(source.name().size() + 2) + ")");
        return;
    }
    throw cut_off.value_or(refused);
}

}  // namespace

void parse_off(FileContents& file, MeshFile& mesh) {
    try {
        read_lines(file, mesh);
    } catch (const TextError& refused) {
        read_numbers(file, refused, mesh);
    }
    give_stated_frame(head_of(file.text), file.source, mesh);
}

/// By its first word. Binary files too, so that they are refused as such.
bool looks_like_off(const FileSource& source) {
    return !header_word(without_byte_order_mark(source.sample())).empty();
}

/// By its counts, which the format allows to come first.
bool looks_like_headless_off(const FileSource& source) {
    try {
        OffParser(without_byte_order_mark(source.sample()), OffLayout::lines, source.parallel()).header();
    } catch (const TextError&) {
        return false;
    }
    return is_text(source.sample());
}

}  // namespace lamella
