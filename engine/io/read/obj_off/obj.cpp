// Wavefront OBJ: vertices and faces. All other statements are skipped, with a warning where they may hold a shape.

#include "base/words.hpp"
#include "io/read/faces.hpp"
#include "io/read/stated.hpp"

namespace lamella {

namespace {

/// Statements that hold no shape, or are part of one that a warning names. A file may begin with the first of them.
constexpr std::array<std::string_view, 34> passed_over = {
    "vt",     "vn",         "vp",        "l",      "p",      "g",    "o",     "s",        "mg",
    "usemtl", "mtllib",     "usemap",    "maplib", "cstype", "deg",  "bevel", "c_interp", "d_interp",
    "lod",    "shadow_obj", "trace_obj", "ctech",  "stech",  "bmat", "step",  "parm",     "trim",
    "hole",   "scrv",       "sp",        "end",    "con",    "res",  "csh"};
constexpr std::size_t may_begin_file = 15;

/// A vertex or a face.
enum class Statement { vertex, face, other, none };

/// The statement that begins at `p`, where a character is.
Statement statement_at(const char* p, const char* end) {
    const auto length = skip_word(p, end) - p;
    if (length == 1 && (*p == 'v' || *p == 'f')) {
        return *p == 'v' ? Statement::vertex : Statement::face;
    }
    return length == 2 && p[0] == 'f' && p[1] == 'o' ? Statement::face : Statement::other;
}

/// Joins lines to the next where they end in a backslash, by writing blanks over both. Comments join no lines. A backslash
/// stays where some readers go on with the word before it in the next line, and others begin one; and at the end of a name
/// (`usemtl textures\`) where the next line is a vertex or a face: these are returned.
LeftOut join_lines(FileContents& file) {
    LeftOut after_backslash;
    StopPace pace = pace_of(file.source.parallel());
    const std::string_view text = file.text;
    const char* const end = text.data() + text.size();
    bool is_shape = false;   // the statement that goes on
    std::size_t joined = 0;  // where it does
    for (std::size_t at = text.find('\\'); at < text.size(); at = text.find('\\', at + 1)) {
        pace.spend(step_work);
        if (at + 1 == text.size() || !ends_line(text[at + 1])) {
            continue;
        }
        const std::size_t line_end = text.substr(joined, at - joined).find_last_of("\r\n");
        const std::size_t line = line_end == std::string_view::npos ? joined : joined + line_end + 1;
        const char* const begin = skip_blank(text.data() + line, end);
        is_shape = line == 0 || line != joined ? statement_at(begin, end) != Statement::other : is_shape;
        const std::size_t next = at + (text.substr(at + 1).starts_with("\r\n") ? 3 : 2);
        if (text.substr(line, at - line).find('#') != std::string_view::npos) {
            continue;
        }
        if (!is_shape) {
            const char* const word = skip_blank(text.data() + next, end);
            if (word != end && statement_at(word, end) != Statement::other) {
                after_backslash.add(word);
                continue;
            }
        } else if (next < text.size() && !is_space(text[next]) && at > line && !is_blank(text[at - 1])) {
            continue;
        }
        std::byte* const bytes = file.bytes.data() + (text.data() - file.whole.data());
        std::fill(bytes + at, bytes + next - 1, std::byte{' '});
        bytes[next - 1] = static_cast<std::byte>(joined_line_end);
        joined = next;
    }
    return after_backslash;
}

/// Contents of a piece beside vertices and faces.
struct ObjNotes {
    PartMarks names;
    LeftOut skipped;   ///< statements that may hold a shape and are not read
    LeftOut decimals;  ///< vertex numbers with decimals that are 0

    void add(const ObjNotes& next, std::size_t first_triangle) {
        add_marks(names, next.names, first_triangle);
        skipped.add(next.skipped);
        decimals.add(next.decimals);
    }
};

/// Reads the statements of one piece twice: its vertices are counted before numbers that count from them are read.
///
///     v X Y Z [W | R G B [A]]
///     f CORNER CORNER CORNER ...          with CORNER = V[/[VT][/[VN]]]; also fo, of old
class ObjParser : private LineParser {
public:
    ObjParser(std::string_view piece, ObjNotes& notes) : LineParser(piece), notes_(notes) {}

    std::size_t count_vertices() {
        std::size_t count = 0;
        for (Statement statement = next(); statement != Statement::none; statement = next()) {
            count += statement == Statement::vertex ? 1 : 0;
            skip_rest();
        }
        return count;
    }

    /// `vertex_count` is the whole file's, as faces may refer to later vertices.
    void parse(const TextPiece& piece, std::size_t vertex_count, std::byte* coordinates, FaceList& faces) {
        constexpr int weight_or_colour = 4;
        vertex_count_ = vertex_count;
        seen_ = piece.first;
        for (Statement statement = next(); statement != Statement::none; statement = next()) {
            if (statement == Statement::vertex) {
                double xyz[3];
                vertex(xyz, weight_or_colour);
                std::memcpy(coordinates + seen_ * sizeof xyz, xyz, sizeof xyz);
                ++seen_;
            } else if (statement == Statement::face) {
                face();
                faces.add(corners_, statement_);
            } else if (!skips_silently()) {
                notes_.skipped.add(statement_);
            } else if (p_ - statement_ == 1 && (*statement_ == 'o' || *statement_ == 'g')) {
                add_mark(notes_.names, faces.triangles(), *statement_ == 'g', p_, skip_line(p_, end_));
            }
            skip_rest();
        }
    }

private:
    /// To the next statement, past its first word.
    Statement next() {
        if (!next_word()) {
            return Statement::none;
        }
        statement_ = p_;
        p_ = skip_word(p_, end_);
        return statement_at(statement_, p_);
    }

    /// Whether a statement that is not read holds no shape, or is part of one that a warning names.
    bool skips_silently() {
        const std::string_view word(statement_, static_cast<std::size_t>(p_ - statement_));
        return std::find(passed_over.begin(), passed_over.end(), word) != passed_over.end();
    }

    void face() {
        corners_.clear();
        while (to_word()) {
            corners_.push_back(corner());
        }
    }

    std::uint32_t corner() {
        const char* const begin = p_;
        const bool from_here = *p_ == '-';
        p_ += static_cast<int>(from_here);
        const char* const digits = p_;
        std::uint64_t number = 0;
        p_ = read_digits(digits, end_, number);
        skip_zero_decimals(begin);
        if (p_ == digits || !references() || !word_ends(p_)) {
            p_ = begin;
            fail("malformed vertex number " + found());
        }
        if (number == 0 || number > (from_here ? seen_ : vertex_count_)) {
            p_ = begin;
            out_of_range(from_here);
        }
        return static_cast<std::uint32_t>(from_here ? seen_ - number : number - 1);
    }

    /// "1.0" is the 1 of a program that knows only one type of numbers.
    void skip_zero_decimals(const char* corner) {
        if (p_ == corner || p_ == end_ || *p_ != '.') {
            return;
        }
        const char* p = p_ + 1;
        while (p != end_ && *p == '0') {
            ++p;
        }
        if (word_ends(p)) {
            p_ = p;
            notes_.decimals.add(corner);
        }
    }

    /// The numbers of a corner's texture vertex and normal, which may be left out.
    bool references() {
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

    [[noreturn]] void out_of_range(bool from_here) const {
        fail("vertex number out of range: " +
             (from_here ? std::to_string(seen_) + " vertices precede, found "
                        : "the file has " + counted(vertex_count_, "vertex", "vertices") + ", found ") +
             found());
    }

    ObjNotes& notes_;
    std::vector<std::uint32_t> corners_;  // of a face
    std::size_t vertex_count_ = 0;
    std::size_t seen_ = 0;             // vertices before this statement, in the whole file
    const char* statement_ = nullptr;  // where it begins
};

void warn_of(const LeftOut& found, const std::string& words, const FileContents& file, MeshFile& mesh) {
    if (found.count > 0) {
        mesh.warnings.push_back(file.source.name() + ": " + words + first_word_words(found, file.whole));
    }
}

}  // namespace

void parse_obj(FileContents& file, MeshFile& mesh) {
    const FileSource& source = file.source;
    const LeftOut after_backslash = join_lines(file);
    std::vector<TextPiece> pieces = cut_at_lines(file.text);
    source.parallel().run(pieces.size(), [&](std::size_t i, int) {
        ObjNotes parse_takes_them;
        pieces[i].count = ObjParser(pieces[i].text, parse_takes_them).count_vertices();
    });
    const std::size_t vertices = number_items(pieces);
    std::vector<ObjNotes> notes(pieces.size());
    std::vector<std::size_t> triangles(pieces.size());
    const auto parse = [&](std::size_t i, std::byte* coordinates, FaceList& faces) {
        ObjParser(pieces[i].text, notes[i]).parse(pieces[i], vertices, coordinates, faces);
        triangles[i] = faces.triangles();
    };
    read_faces(file, vertices, pieces.size(), parse, mesh);
    ObjNotes all;
    std::size_t first_triangle = 0;
    for (std::size_t i = 0; i < notes.size(); ++i) {
        all.add(notes[i], std::exchange(first_triangle, first_triangle + triangles[i]));
    }
    give_parts(all.names, true, source.name(), mesh);
    give_stated_frame(head_comments(file.text), source, mesh);
    warn_of(all.skipped, "ignored " + counted(all.skipped.count, "statement that is", "statements that are") + " not read",
            file, mesh);
    warn_of(all.decimals, counted(all.decimals.count, "vertex number") + " with decimals, which are 0", file, mesh);
    warn_of(after_backslash,
            "read " + counted(after_backslash.count, "vertex or face", "vertices and faces") +
                " after a line that ends in a backslash",
            file, mesh);
}

/// By its first statement, as nothing marks the format.
bool looks_like_obj(const FileSource& source) {
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
    const auto* const last = passed_over.begin() + may_begin_file;
    return word_end != end &&
           (statement_at(begin, end) != Statement::other || std::find(passed_over.begin(), last, word) != last);
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

}  // namespace lamella
