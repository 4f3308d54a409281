// OFF, as text: a header, two counts, then a line for each vertex and for each face.
//
//     [ST][C][N]OFF                 may be left out where the file's name says what it is
//     VERTICES FACES [EDGES]        on a line of its own or on the header's
//     X Y Z ...                     for each vertex; normal, colour and texture are skipped
//     CORNERS V V V ... [COLOUR]    for each face, with vertices numbered from 0
#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/read/obj_off/faces.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/text/lines.hpp"

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

struct Counts {
    std::size_t vertices = 0;
    std::size_t faces = 0;
    const char* at = nullptr;

    std::size_t lines() const { return vertices + faces; }
    std::string words() const { return counted(vertices, "vertex", "vertices") + " and " + counted(faces, "face"); }
};

/// Reads the lines of a piece twice: count() finds how much parse() writes. Every line that is not empty and no comment is a
/// vertex or a face.
class OffParser : private LineParser {
public:
    explicit OffParser(std::string_view text) : LineParser(text.data(), text.data() + text.size(), false) {}

    /// Reads the file's head, which rest() then follows.
    bool header(Counts& counts);
    const char* rest() const { return p_; }

    /// The number of lines, at most `most`. All but the first `vertices` are counted as faces.
    std::size_t count(FaceRange& faces, std::size_t vertices = 0,
                      std::size_t most = std::numeric_limits<std::size_t>::max());

    bool parse(const TextPiece& piece, const Counts& counts, std::byte* coordinates, FaceWriter& faces);

    /// Where the face of this number begins, of those with three corners or more, after `vertices` lines. Precondition:
    /// the piece has so many.
    const char* place_of_face(std::size_t vertices, std::size_t number);

    using LineParser::failure;

private:
    bool next_line();
    bool whole_number(std::size_t& number, const char* what);
    std::size_t corners_of_line(const char* line_end) const;
    bool face(std::size_t vertex_count, FaceWriter& faces);
    bool corner(std::size_t vertex_count, FaceWriter& faces);
};

/// To the next line that holds anything.
bool OffParser::next_line() {
    for (p_ = skip_space(p_, end_); !to_word(); p_ = skip_space(skip_line(p_, end_), end_)) {
        if (p_ == end_) {
            return false;
        }
    }
    return true;
}

bool OffParser::whole_number(std::size_t& number, const char* what) {
    constexpr std::size_t limit = std::size_t{1} << 53;
    if (!to_word()) {
        return fail(std::string("expected ") + what + ", found " + found());
    }
    const char* const begin = p_;
    p_ = read_digits(begin, end_, number);
    number = std::min(number, limit);
    if (p_ == begin || !word_ends(p_)) {
        p_ = begin;
        return fail(std::string("expected ") + what + ", found " + found());
    }
    return true;
}

bool OffParser::header(Counts& counts) {
    const std::string_view word = header_word({p_, static_cast<std::size_t>(end_ - p_)});
    p_ = word.empty() ? p_ : word.data();
    if (word.find_first_of("4n") != std::string_view::npos) {
        return fail("vertices of other than three coordinates are not read: " + found());
    }
    p_ += word.size();
    std::size_t edges = 0;
    if (!to_word()) {
        next_line();
    }
    counts.at = p_;
    return whole_number(counts.vertices, "the number of vertices") && whole_number(counts.faces, "the number of faces") &&
           (!to_word() || whole_number(edges, "the number of edges")) && other_numbers(0);
}

/// What a face's line begins with, where the line is long enough for so many corners.
std::size_t OffParser::corners_of_line(const char* line_end) const {
    std::uint64_t corners = 0;
    read_digits(p_, line_end, corners);
    return corners > static_cast<std::size_t>(line_end - p_) / 2 ? 0 : corners;  // parse() will say so
}

std::size_t OffParser::count(FaceRange& faces, std::size_t vertices, std::size_t most) {
    std::size_t lines = 0;
    for (; lines < most && next_line(); ++lines) {
        const char* const line_end = skip_line(p_, end_);
        if (lines >= vertices) {
            faces.add(corners_of_line(line_end), p_);
        }
        p_ = line_end;
    }
    return lines;
}

bool OffParser::parse(const TextPiece& piece, const Counts& counts, std::byte* coordinates, FaceWriter& faces) {
    constexpr int normal_colour_and_texture = 3 + 4 + 2;
    const std::size_t last = std::min(piece.end_item(), counts.lines());
    for (std::size_t line = piece.first; line < last; ++line) {
        next_line();
        if (line < counts.vertices) {
            double xyz[3];
            if (!vertex(xyz, normal_colour_and_texture)) {
                return false;
            }
            std::memcpy(coordinates + line * sizeof xyz, xyz, sizeof xyz);
        } else if (!face(counts.vertices, faces)) {
            return false;
        }
        p_ = skip_line(p_, end_);
    }
    return true;
}

const char* OffParser::place_of_face(std::size_t vertices, std::size_t number) {
    for (;; p_ = skip_line(p_, end_)) {
        next_line();
        if (vertices > 0) {
            --vertices;
        } else if (corners_of_line(skip_line(p_, end_)) >= 3 && number-- == 0) {
            return p_;
        }
    }
}

bool OffParser::face(std::size_t vertex_count, FaceWriter& faces) {
    constexpr int colour = 4;
    const char* const begin = p_;
    const std::size_t held = corners_of_line(skip_line(p_, end_));
    std::size_t corners = 0;
    if (!whole_number(corners, "the number of a face's corners")) {
        return false;
    }
    if (corners != held) {
        p_ = begin;
        return fail("the face counts " + std::to_string(corners) + " corners, more than its line holds");
    }
    for (std::size_t i = 0; i < corners; ++i) {
        if (!corner(vertex_count, faces)) {
            return false;
        }
    }
    if (corners < 3) {
        faces.drop_face();
    } else {
        faces.end_face();
    }
    return other_numbers(colour);
}

bool OffParser::corner(std::size_t vertex_count, FaceWriter& faces) {
    std::size_t vertex = 0;
    to_word();
    const char* const begin = p_;
    if (!whole_number(vertex, "a vertex number")) {
        return false;
    }
    if (vertex >= vertex_count) {
        p_ = begin;
        return fail("vertex number out of range: the file has " + counted(vertex_count, "vertex", "vertices") + ", found " +
                    found());
    }
    faces.add_corner(static_cast<std::uint32_t>(vertex));
    return true;
}

/// Counts what the pieces hold, each vertex and face on a line of its own.
std::vector<FaceRange> count_faces(std::vector<TextPiece>& pieces, const Counts& counts, const Parallel& parallel) {
    std::vector<FaceRange> faces(pieces.size());
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].count = OffParser(pieces[i].text).count(faces[i]); });
    number_items(pieces);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        if (pieces[i].first < counts.vertices || pieces[i].end_item() > counts.lines()) {  // not all of them are faces
            faces[i] = {};
            if (pieces[i].end_item() > counts.vertices && pieces[i].first < counts.lines()) {
                const std::size_t vertices = counts.vertices - std::min(counts.vertices, pieces[i].first);
                OffParser(pieces[i].text).count(faces[i], vertices, counts.lines() - pieces[i].first);
            }
        }
    }
    return faces;
}

}  // namespace

/// By its first word. Binary files too, so that they are refused as such.
bool looks_like_off(const FileSource& source) {
    return !header_word(without_byte_order_mark(source.sample())).empty();
}

/// By its counts, which the format allows to come first.
bool looks_like_headless_off(const FileSource& source) {
    Counts counts;
    return is_text(source.sample()) && OffParser(without_byte_order_mark(source.sample())).header(counts);
}

Result<MeshFile> read_off(FileSource& source) {
    if (!is_text(source.sample())) {
        return source.error(ErrorCode::malformed_mesh, "is a binary OFF file; only OFF as text is read", 0);
    }
    const Result<FileText> contents = source.take_text();
    if (!contents) {
        return contents.error();
    }
    const std::string_view whole = contents->whole;
    const std::string_view text = contents->text;
    const auto failed = [&](const TextFailure& failure) {
        return source.error_in_text(whole, static_cast<std::size_t>(failure.at - whole.data()), failure.what);
    };
    OffParser head(text);
    Counts counts;
    if (!head.header(counts)) {
        return failed(head.failure());
    }
    const std::string_view body = text.substr(static_cast<std::size_t>(head.rest() - text.data()));
    // The shortest lines are "0 0 0" and, of a face without corners, "0"; the last may lack its end.
    if (6 * counts.vertices + 2 * counts.faces > body.size() + 1) {
        return failed({counts.at, "counts " + counts.words() + ", more than the " + std::to_string(body.size()) +
                                      " bytes that follow can hold"});
    }
    std::vector<TextPiece> pieces = cut_at_lines(body);
    std::vector<FaceRange> faces = count_faces(pieces, counts, source.parallel());
    const std::size_t lines = pieces.empty() ? 0 : pieces.back().end_item();
    Result<MeshFile> mesh = read_faces(
        source, whole, std::min(counts.vertices, lines), faces,
        [&](std::size_t i, std::byte* coordinates, FaceWriter& writer) {
            OffParser parser(pieces[i].text);
            const bool parsed = parser.parse(pieces[i], counts, coordinates, writer);
            if (parsed && i + 1 == pieces.size() && lines < counts.lines()) {
                return TextFailure{body.data() + body.size(), "expected " + counts.words() + ", found the end of the file"};
            }
            return parser.failure();
        },
        [&](std::size_t i, std::size_t face) {
            const std::size_t first = std::max(pieces[i].first, counts.vertices);
            return OffParser(pieces[i].text).place_of_face(first - pieces[i].first, face);
        });
    if (mesh) {
        give_stated_frame(text.substr(0, static_cast<std::size_t>(counts.at - text.data())), source, mesh.value());
        mesh->parse_ms = milliseconds_since(contents->taken);
        if (lines > counts.lines()) {
            mesh->warnings.push_back(source.name() + ": ignored " + counted(lines - counts.lines(), "line") +
                                     " after the last of " + counted(counts.faces, "face"));
        }
    }
    return mesh;
}

}  // namespace lamella
