// Wavefront OBJ: vertices and faces. All other statements are skipped, with a warning where they may hold a shape.
#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/clock.hpp"
#include "base/words.hpp"
#include "io/read/obj_off/faces.hpp"
#include "io/read/part_marks.hpp"
#include "io/read/reader.hpp"
#include "io/read/stated_frame.hpp"
#include "io/text/lines.hpp"

namespace lamella {

namespace {

/// Reads the statements of one piece twice: count() finds how much parse() writes.
///
///     v X Y Z [W | R G B [A]]
///     f CORNER CORNER CORNER ...          with CORNER = V[/[VT][/[VN]]]; also fo, of old
class ObjParser : private LineParser {
public:
    explicit ObjParser(std::string_view piece) : LineParser(piece.data(), piece.data() + piece.size(), true) {}

    /// Statements that may hold a shape and are not read go to `skipped`.
    void count(TextPiece& piece, FaceRange& faces, PartMarks& names, LeftOut& skipped);

    /// `vertex_count` is the whole file's, as faces may refer to later vertices.
    bool parse(const TextPiece& piece, std::size_t vertex_count, std::byte* coordinates, FaceWriter& faces);

    /// Where the piece's face of this number begins, of those with three corners or more. Precondition: it has so many.
    const char* place_of_face(std::size_t number);

    /// Vertex numbers with decimals that are 0.
    const LeftOut& decimals() const { return decimals_; }
    /// Vertices and faces in a line after one that is not read and ends in a backslash.
    const LeftOut& after_backslash() const { return after_backslash_; }
    using LineParser::failure;

private:
    enum class Statement { vertex, face, other, none };

    /// To the next statement; past its first word if it is one that is read.
    Statement next();
    bool skips_silently();
    void skip_other();
    void skip_rest_of(Statement statement) { statement == Statement::other ? skip_other() : skip_rest(); }
    Statement shape_at(const char* p) const;
    bool face(FaceWriter& faces);
    bool corner(FaceWriter& faces);
    void skip_zero_decimals(const char* corner);
    bool references();
    bool out_of_range(bool from_here);

    LeftOut decimals_;
    LeftOut after_backslash_;
    std::size_t vertex_count_ = 0;
    std::size_t seen_ = 0;             // vertices before this statement, in the whole file
    const char* statement_ = nullptr;  // where it begins
};

ObjParser::Statement ObjParser::next() {
    for (p_ = skip_space(p_, end_); !to_word(); p_ = skip_space(skip_line(p_, end_), end_)) {
        if (p_ == end_) {
            return Statement::none;
        }
    }
    statement_ = p_;
    const Statement statement = shape_at(p_);
    if (statement != Statement::other) {
        p_ += word_ends(p_ + 1) ? 1 : 2;
    }
    return statement;
}

/// What begins at `p`, where a character is.
ObjParser::Statement ObjParser::shape_at(const char* p) const {
    if (word_ends(p + 1) && (*p == 'v' || *p == 'f')) {
        return *p == 'v' ? Statement::vertex : Statement::face;
    }
    return *p == 'f' && p[1] == 'o' && word_ends(p + 2) ? Statement::face : Statement::other;
}

/// To the end of a statement that is not read. A backslash at the end of a line is part of a name (`usemtl textures\`) where
/// the next line is a vertex or a face. Comments join no lines.
void ObjParser::skip_other() {
    for (;;) {
        const char* const line_end = skip_line(p_, end_);
        const std::string_view line(p_, static_cast<std::size_t>(line_end - p_));
        const bool joined = line_end != end_ && line_end[-1] == '\\' && line.find('#') == std::string_view::npos;
        p_ = line_end;
        if (!joined) {
            return;
        }
        const char* const next = skip_blank(line_end - 1 + continuation_at(line_end - 1, end_), end_);
        if (next != end_ && shape_at(next) != Statement::other) {
            after_backslash_.add(next);
            return;
        }
        p_ = next;
    }
}

/// Skips the first word of a statement that is not read. Whether the statement holds no shape, or is part of one that a
/// warning names.
bool ObjParser::skips_silently() {
    constexpr std::array<std::string_view, 34> known = {
        "vt",        "vn",     "vp",     "l",      "p",     "g",        "o",        "s",    "mg",
        "usemtl",    "mtllib", "usemap", "maplib", "bevel", "c_interp", "d_interp", "lod",  "shadow_obj",
        "trace_obj", "ctech",  "stech",  "cstype", "deg",   "bmat",     "step",     "parm", "trim",
        "hole",      "scrv",   "sp",     "end",    "con",   "res",      "csh"};
    skip_word();
    const std::string_view word(statement_, static_cast<std::size_t>(p_ - statement_));
    return std::find(known.begin(), known.end(), word) != known.end();
}

void ObjParser::count(TextPiece& piece, FaceRange& faces, PartMarks& names, LeftOut& skipped) {
    for (Statement statement = next(); statement != Statement::none; statement = next()) {
        if (statement == Statement::face) {
            faces.add(count_words(), statement_);
        } else if (statement == Statement::vertex) {
            ++piece.count;
        } else if (!skips_silently()) {
            skipped.add(statement_);
        } else if (p_ - statement_ == 1 && (*statement_ == 'o' || *statement_ == 'g')) {
            add_mark(names, faces.triangles, *statement_ == 'g', p_, skip_line(p_, end_));
        }
        skip_rest_of(statement);
    }
}

bool ObjParser::parse(const TextPiece& piece, std::size_t vertex_count, std::byte* coordinates, FaceWriter& faces) {
    constexpr int weight_or_colour = 4;
    vertex_count_ = vertex_count;
    seen_ = piece.first;
    for (Statement statement = next(); statement != Statement::none; statement = next()) {
        if (statement == Statement::vertex) {
            double xyz[3];
            if (!vertex(xyz, weight_or_colour)) {
                return false;
            }
            std::memcpy(coordinates + seen_ * sizeof xyz, xyz, sizeof xyz);
            ++seen_;
        } else if (statement == Statement::face && !face(faces)) {
            return false;
        }
        skip_rest_of(statement);
    }
    return true;
}

const char* ObjParser::place_of_face(std::size_t number) {
    for (Statement statement = next();; statement = next()) {
        if (statement == Statement::face && count_words() >= 3 && number-- == 0) {
            return statement_;
        }
        skip_rest_of(statement);
    }
}

bool ObjParser::face(FaceWriter& faces) {
    while (to_word()) {
        if (!corner(faces)) {
            return false;
        }
    }
    if (faces.corners() >= polygon_mark) {
        p_ = statement_;
        return fail("the face has " + std::to_string(faces.corners()) + " corners, too many to be cut into triangles");
    }
    if (faces.corners() < 3) {
        faces.drop_face();
    } else {
        faces.end_face();
    }
    return true;
}

bool ObjParser::corner(FaceWriter& faces) {
    const char* const begin = p_;
    const bool from_here = *p_ == '-';
    p_ += static_cast<int>(from_here);
    const char* const digits = p_;
    std::uint64_t number = 0;
    p_ = read_digits(digits, end_, number);
    skip_zero_decimals(begin);
    if (p_ == digits || !references() || !word_ends(p_)) {
        p_ = begin;
        return fail("malformed vertex number " + found());
    }
    if (number == 0 || number > (from_here ? seen_ : vertex_count_)) {
        p_ = begin;
        return out_of_range(from_here);
    }
    faces.add_corner(static_cast<std::uint32_t>(from_here ? seen_ - number : number - 1));
    return true;
}

/// "1.0" is the 1 of a program that knows only one type of numbers.
void ObjParser::skip_zero_decimals(const char* corner) {
    if (p_ == corner || p_ == end_ || *p_ != '.') {
        return;
    }
    const char* p = p_ + 1;
    while (p != end_ && *p == '0') {
        ++p;
    }
    if (word_ends(p)) {
        p_ = p;
        decimals_.add(corner);
    }
}

/// The numbers of a corner's texture vertex and normal, which may be left out.
bool ObjParser::references() {
    const char* p = p_;
    bool good = true;
    for (int i = 0; i < 2 && good && p != end_ && *p == '/'; ++i) {
        ++p;
        const bool from_here = p != end_ && *p == '-';
        p += static_cast<int>(from_here);
        const char* const digits = p;
        while (p != end_ && is_digit(*p)) {
            ++p;
        }
        good = !from_here || p != digits;
    }
    p_ = p;
    return good;
}

bool ObjParser::out_of_range(bool from_here) {
    return fail("vertex number out of range: " +
                (from_here ? std::to_string(seen_) + " vertices precede, found "
                           : "the file has " + counted(vertex_count_, "vertex", "vertices") + ", found ") +
                found());
}

LeftOut sum_of(std::span<const LeftOut> pieces) {
    LeftOut sum;
    for (const LeftOut& piece : pieces) {
        sum.add(piece);
    }
    return sum;
}

void warn_of(const LeftOut& found, const std::string& words, const FileSource& source, std::string_view text,
             MeshFile& mesh) {
    if (found.count > 0) {
        mesh.warnings.push_back(source.name() + ": " + words + first_word_words(found, text));
    }
}

}  // namespace

/// By its first statement, as nothing marks the format.
bool looks_like_obj(const FileSource& source) {
    constexpr std::array<std::string_view, 18> statements = {"v",      "vt",     "vn",     "vp",     "f",      "fo",
                                                             "l",      "p",      "g",      "o",      "s",      "mg",
                                                             "mtllib", "usemtl", "usemap", "cstype", "maplib", "deg"};
    const std::string_view text = without_byte_order_mark(source.sample());
    const std::string_view head = head_comments(text);
    if (!is_text(text) || head.find("# vtk") != std::string_view::npos) {
        return false;
    }
    const char* const begin = text.data() + head.size();
    const char* const end = text.data() + text.size();
    if (begin == end) {
        return !head.empty();  // nothing but comments
    }
    const char* const word_end = skip_word(begin, end);
    const std::string_view word(begin, static_cast<std::size_t>(word_end - begin));
    // A statement goes on after its first word; other text may be a single letter.
    return word_end != end && std::find(statements.begin(), statements.end(), word) != statements.end();
}

/// By a vertex further down: what precedes it is then left out with a warning, as a comment without its '#'.
bool may_be_obj(const FileSource& source) {
    const std::string_view text = source.sample();
    const char* const end = text.data() + text.size();
    for (const char* line = text.data(); line != end; line = skip_space(skip_line(line, end), end)) {
        if (end - line > 2 && *line == 'v' && is_blank(line[1])) {
            const char first = *skip_blank(line + 1, end - 1);
            return is_text(text) && (is_digit(first) || first == '-' || first == '+' || first == '.');
        }
    }
    return false;
}

Result<MeshFile> read_obj(FileSource& source) {
    if (!is_text(source.sample())) {
        return source.error(ErrorCode::malformed_mesh, "is no OBJ file as text; no other OBJ is read", 0);
    }
    const Result<FileText> contents = source.take_text();
    if (!contents) {
        return contents.error();
    }
    const std::string_view whole = contents->whole;
    const std::string_view text = contents->text;
    std::vector<TextPiece> pieces = cut_at_lines(text);
    std::vector<FaceRange> faces(pieces.size());
    std::vector<PartMarks> names(pieces.size());
    std::vector<LeftOut> skipped(pieces.size());
    std::vector<LeftOut> decimals(pieces.size());
    std::vector<LeftOut> after_backslash(pieces.size());
    source.parallel().run(pieces.size(), [&](std::size_t i, int) {
        ObjParser(pieces[i].text).count(pieces[i], faces[i], names[i], skipped[i]);
    });
    const std::size_t vertices = number_items(pieces);
    Result<MeshFile> mesh = read_faces(
        source, whole, vertices, faces,
        [&](std::size_t i, std::byte* coordinates, FaceWriter& writer) {
            ObjParser parser(pieces[i].text);
            parser.parse(pieces[i], vertices, coordinates, writer);
            decimals[i] = parser.decimals();
            after_backslash[i] = parser.after_backslash();
            return parser.failure();
        },
        [&](std::size_t i, std::size_t face) { return ObjParser(pieces[i].text).place_of_face(face); });
    if (mesh) {
        for (std::size_t i = 1; i < names.size(); ++i) {
            add_marks(names.front(), names[i], faces[i].first_triangle);
        }
        give_parts(names.front(), true, source.name(), mesh.value());
        give_stated_frame(head_comments(text), source, mesh.value());
        const LeftOut ignored = sum_of(skipped);
        const LeftOut with_decimals = sum_of(decimals);
        const LeftOut rescued = sum_of(after_backslash);
        warn_of(ignored, "ignored " + counted(ignored.count, "statement that is", "statements that are") + " not read",
                source, whole, mesh.value());
        warn_of(with_decimals, counted(with_decimals.count, "vertex number") + " with decimals, which are 0", source, whole,
                mesh.value());
        warn_of(rescued,
                "read " + counted(rescued.count, "vertex or face", "vertices and faces") +
                    " after a line that ends in a backslash",
                source, whole, mesh.value());
        mesh->parse_ms = milliseconds_since(contents->taken);
    }
    return mesh;
}

}  // namespace lamella
