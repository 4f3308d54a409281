// OFF, as text: a header, two counts, then a line for each vertex and for each face. Where lines end elsewhere,
// off_tokens.hpp takes over.
//
//     [ST][C][N]OFF                 may be left out where the file's name says what it is
//     VERTICES FACES [EDGES]        on lines of their own or on the header's
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
#include "io/read/obj_off/off_numbers.hpp"
#include "io/read/obj_off/off_tokens.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/text/lines.hpp"

namespace lamella {

namespace {

/// Reads the lines of a piece twice: count() finds how much parse() writes. Every line that is not empty and no comment is a
/// vertex or a face.
class OffParser : private OffNumbers {
public:
    explicit OffParser(std::string_view text) : OffNumbers(text) {}

    /// The number of lines, at most `most`. All but the first `vertices` are counted as faces.
    std::size_t count(FaceRange& faces, std::size_t vertices = 0,
                      std::size_t most = std::numeric_limits<std::size_t>::max());

    bool parse(const TextPiece& piece, const OffCounts& counts, std::byte* coordinates, FaceWriter& faces);

    /// Where the face of this number begins, of those with three corners or more, after `vertices` lines. Precondition:
    /// the piece has so many.
    const char* place_of_face(std::size_t vertices, std::size_t number);

    using OffNumbers::failure;

private:
    std::size_t corners_of_line(const char* line_end) const;
    bool face(std::size_t vertex_count, FaceWriter& faces);
};

/// What a face's line begins with, where the line is long enough for so many corners.
std::size_t OffParser::corners_of_line(const char* line_end) const {
    std::uint64_t corners = 0;
    read_digits(p_, line_end, corners);
    return corners > static_cast<std::size_t>(line_end - p_) / 2 ? 0 : corners;  // parse() will say so
}

std::size_t OffParser::count(FaceRange& faces, std::size_t vertices, std::size_t most) {
    std::size_t lines = 0;
    for (; lines < most && next_word(); ++lines) {
        const char* const line_end = skip_line(p_, end_);
        if (lines >= vertices) {
            faces.add(corners_of_line(line_end), p_);
        }
        p_ = line_end;
    }
    return lines;
}

bool OffParser::parse(const TextPiece& piece, const OffCounts& counts, std::byte* coordinates, FaceWriter& faces) {
    constexpr int normal_colour_and_texture = 3 + 4 + 2;
    const std::size_t last = std::min(piece.end_item(), counts.lines());
    for (std::size_t line = piece.first; line < last; ++line) {
        next_word();
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
        next_word();
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
        std::uint32_t vertex = 0;
        if (!vertex_number(vertex_count, vertex)) {
            return false;
        }
        faces.add_corner(vertex);
    }
    if (corners < 3) {
        faces.drop_face();
    } else {
        faces.end_face();
    }
    return other_numbers(colour);
}

/// Counts what the pieces hold, each vertex and face on a line of its own.
std::vector<FaceRange> count_faces(std::vector<TextPiece>& pieces, const OffCounts& counts, const Parallel& parallel) {
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

/// Each vertex and each face on a line of its own. Lines after the last are left out with a warning.
Result<MeshFile> read_off_lines(const FileSource& source, std::string_view whole, std::string_view body,
                                const OffCounts& counts) {
    if (!counts.fit(body.size())) {
        return source.error_in_text(whole, {counts.at, "counts " + counts.words() + ", more than the " +
                                                           std::to_string(body.size()) + " bytes that follow can hold"});
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
    if (mesh && lines > counts.lines()) {
        mesh->warnings.push_back(source.name() + ": ignored " + counted(lines - counts.lines(), "line") +
                                 " after the last of " + counted(counts.faces, "face"));
    }
    return mesh;
}

/// The same of a file that is not as lines. The error is `refused`, that of the lines, unless the file ends too early.
Result<MeshFile> read_off_words(const FileSource& source, std::string_view whole, std::string_view text,
                                const Error& refused) {
    TextFailure failure;
    const auto offset = static_cast<std::size_t>(refused.byte_offset);
    if (std::optional<Result<MeshFile>> mesh = read_off_tokens(source, whole, text, offset, failure)) {
        if (*mesh) {
            (*mesh)->warnings.push_back(source.name() +
                                        ": was read number by number, as it is not one vertex or one face a line (" +
                                        refused.message.substr(source.name().size() + 2) + ")");
        }
        return *std::move(mesh);
    }
    if (failure.at == nullptr) {
        return refused;
    }
    return source.error_in_text(whole, failure);
}

}  // namespace

/// By its first word. Binary files too, so that they are refused as such.
bool looks_like_off(const FileSource& source) {
    return !off_header_word(without_byte_order_mark(source.sample())).empty();
}

/// By its counts, which the format allows to come first.
bool looks_like_headless_off(const FileSource& source) {
    OffCounts counts;
    return is_text(source.sample()) && OffNumbers(without_byte_order_mark(source.sample())).header(counts);
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
    OffNumbers head(text);
    OffCounts counts;
    const bool has_head = head.header(counts);
    const auto offset_of = [&](const char* at) { return static_cast<std::size_t>(at - text.data()); };
    Result<MeshFile> mesh = has_head ? read_off_lines(source, whole, text.substr(offset_of(head.rest())), counts)
                                     : source.error_in_text(whole, head.failure());
    if (!mesh && mesh.error().code == ErrorCode::malformed_mesh) {
        mesh = read_off_words(source, whole, text, mesh.error());
    }
    if (mesh) {
        const std::size_t head_bytes = counts.at != nullptr ? offset_of(counts.at) : 0;
        give_stated_frame(text.substr(0, head_bytes), source, mesh.value());
        mesh->parse_ms = milliseconds_since(contents->taken);
    }
    return mesh;
}

}  // namespace lamella
