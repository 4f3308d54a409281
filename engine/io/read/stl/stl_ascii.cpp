// STL as text, parsed in parallel. Any number of `solid NAME-TO-END-OF-LINE`, `endsolid NAME-TO-END-OF-LINE` and
//
//     facet normal N N N  outer loop  vertex X Y Z  vertex X Y Z  vertex X Y Z  endloop  endfacet
//
// in any case and with any white space between words. A name ends before its line does where a facet begins. Normals are
// skipped. Departures from the grammar that leave no doubt about the vertices are read too.
#include "base/words.hpp"
#include "io/read/chunk_list.hpp"
#include "io/read/stated.hpp"

namespace lamella {

namespace {

/// A word of at most eight lower-case letters, compared as one integer.
struct Keyword {
    std::string_view text;
    std::uint64_t letters = 0;

    consteval Keyword(const char* word) : text(word) {  // NOLINT(google-explicit-constructor): an argument
        for (std::size_t i = 0; i < text.size(); ++i) {
            letters |= static_cast<std::uint64_t>(text[i]) << (8 * i);
        }
    }
};

/// True if the text at `p` is `keyword`, in any case, and ends there. Inlined, so that keywords are constants.
[[gnu::always_inline]] inline bool is_word(const char* p, const char* end, const Keyword& keyword) {
    const std::size_t length = keyword.text.size();
    const auto left = static_cast<std::size_t>(end - p);
    if (left < length) {
        return false;
    }
    std::uint64_t letters = 0;
    std::memcpy(&letters, p, left < 8 ? length : 8);
    letters |= 0x2020202020202020;
    return (letters ^ keyword.letters) << (8 * (8 - length)) == 0 && (left == length || is_space(p[length]));
}

bool is_one_of(const char* p, const char* end, std::initializer_list<Keyword> keywords) {
    return std::any_of(keywords.begin(), keywords.end(), [&](const Keyword& keyword) { return is_word(p, end, keyword); });
}

bool is_statement(const char* p, const char* end) {
    return is_one_of(p, end, {"facet", "solid", "endsolid"});
}

/// True if a facet goes on with the word at `p`.
bool is_word_in_facet(const char* p, const char* end) {
    return is_one_of(p, end, {"normal", "outer", "loop", "vertex", "endloop", "endfacet"});
}

const char* next_word(const char* p, const char* end) {
    return skip_space(skip_word(p, end), end);
}

/// True if a facet may begin at `p`, by two words: `facet` may be one of a name or of a comment.
bool may_begin_facet(const char* p, const char* end) {
    return is_word(p, end, "facet") && is_one_of(next_word(p, end), end, {"normal", "outer", "vertex"});
}

/// True if `facet normal N N N outer` begins at `p`: `facet normal` alone may be words of a name.
bool begins_facet(const char* p, const char* end) {
    if (!is_word(p, end, "facet") || !is_word(next_word(p, end), end, "normal")) {
        return false;
    }
    for (int word = 0; word < 5; ++word) {
        p = next_word(p, end);
    }
    return is_word(p, end, "outer");
}

/// A component of a normal: digits, or how some C library spells what is not a number ("-nan(ind)", "1.#QNAN", "inf").
/// Normals are not used, so they are not parsed.
bool passes_for_number(std::string_view word) {
    if (word.find_first_not_of("0123456789.-+eE") == std::string_view::npos) {
        return true;
    }
    const std::string lower = lower_case(word.substr(0, 16));
    return lower.find("nan") != std::string::npos || lower.find("inf") != std::string::npos ||
           lower.find(".#") != std::string::npos;
}

constexpr std::size_t facet_bytes = 9 * sizeof(float);

/// The facets of a piece of text.
struct Facets {
    ChunkList<std::byte, 16 * facet_bytes, 512 * facet_bytes> coordinates;
    LeftOut odd{};  ///< with an unusable normal, or without a word other than `facet` and `vertex`, read all the same
    std::string first_odd{};  ///< what is wrong with the first of them
    LeftOut lines{};          ///< between facets, skipped
    PartMarks solids{};
    const char* open_end = nullptr;  ///< after the last statement, if that is not `endsolid`

    std::uint64_t count() const noexcept { return coordinates.size() / facet_bytes; }
};

/// Reads facets one after the other.
class FacetParser {
public:
    FacetParser(const char* begin, const char* end, const Parallel& parallel, Facets& facets)
        : p_(begin), end_(end), pace_(pace_of(parallel)), facets_(facets) {}

    /// All that begins before `stop`. Throws TextError.
    void parse(const char* stop) {
        TextError skipped;  // the line right before
        bool solid_ended = false;
        const char* last_end = nullptr;
        for (p_ = skip_space(p_, end_); p_ < stop; p_ = skip_space(p_, end_)) {
            if (!is_statement(p_, end_)) {
                other_line(skipped);
                continue;
            }
            skipped = {};
            solid_ended = is_word(p_, end_, "endsolid");
            if (is_word(p_, end_, "facet")) {
                facet();
            } else {
                const char* const name = skip_word(p_, end_);
                p_ = name_end();
                if (!solid_ended) {
                    add_mark(facets_.solids, facets_.count(), false, name, p_);
                }
            }
            last_end = p_;
        }
        facets_.open_end = solid_ended ? nullptr : last_end;
    }

private:
    /// The end of the name after `solid` or `endsolid`: the line's end, or where a facet begins on the same line.
    const char* name_end() {
        const char* p = skip_word(p_, end_);
        while (p != end_ && !ends_line(*p)) {
            pace_.spend(step_work);
            if (begins_facet(p, end_)) {
                return p;
            }
            p = is_space(*p) ? p + 1 : skip_word(p, end_);
        }
        return p;
    }

    /// Skips a line that is no statement, as a comment is. An error where facets would be lost: they begin within it, it
    /// stands in the place of a facet's first line, which `skipped` then tells, or the file is cut off there.
    void other_line(TextError& skipped) {
        const char* const line_end = skip_line(p_, end_);
        const std::string_view rest(p_, static_cast<std::size_t>(end_ - p_));
        const bool is_cut_off = std::string_view("facet").starts_with(rest) || std::string_view("solid").starts_with(rest) ||
                                std::string_view("endsolid").starts_with(rest);
        bool harmless = !is_word_in_facet(p_, end_) && !is_cut_off &&
                        std::memchr(p_, '\0', static_cast<std::size_t>(line_end - p_)) == nullptr;
        for (const char* p = p_; harmless && p < line_end; p = next_word(p, end_)) {
            pace_.spend(step_work);
            harmless = !may_begin_facet(p, end_);
        }
        if (skipped.at == nullptr) {
            skipped = {p_, "expected 'facet', 'solid' or 'endsolid', found " + found()};
        }
        if (!harmless) {
            throw skipped;
        }
        facets_.lines.add(p_);
        p_ = line_end;
    }

    /// What the normal should be is skipped where it is none, as are words after `endloop`; `outer loop` and `endfacet` may
    /// be absent. The first of several departures is the one that is reported.
    void facet() {
        const char* const begin = p_ = skip_word(p_, end_);
        std::optional<TextError> departure;
        if (!normal() || !word("outer", "after the normal") || !word("loop", "after 'outer'")) {
            departure = failure_;
            p_ = begin;
            if (!skip_words(true)) {
                throw *departure;
            }
        }
        float nine[9];
        if (!vertex(nine) || !vertex(nine + 3) || !vertex(nine + 6) || !word("endloop", "after three vertices")) {
            throw departure.value_or(failure_);
        }
        if (!word("endfacet", "after 'endloop'")) {
            departure = departure.value_or(failure_);
            if (!skip_words(false)) {
                throw *departure;
            }
        }
        if (departure) {
            facets_.first_odd = facets_.odd.count == 0 ? departure->what : facets_.first_odd;
            facets_.odd.add(departure->at);
        }
        std::memcpy(facets_.coordinates.room().data(), nine, sizeof nine);
        facets_.coordinates.add(sizeof nine);
    }

    /// Skips words to the next vertex or to after the facet's end, which may be absent where a statement begins.
    bool skip_words(bool to_vertex) {
        p_ = skip_space(p_, end_);
        for (int words = 0; words <= most_words && p_ != end_; ++words, p_ = next_word(p_, end_)) {
            if (is_statement(p_, end_)) {
                return !to_vertex;
            }
            if (to_vertex ? is_one_of(p_, end_, {"vertex", "endloop", "endfacet"}) : is_word_in_facet(p_, end_)) {
                const bool found = to_vertex ? is_word(p_, end_, "vertex") : is_word(p_, end_, "endfacet");
                p_ = found && !to_vertex ? skip_word(p_, end_) : p_;
                return found;
            }
        }
        return false;
    }

    // What follows is read, or is the failure_.

    bool normal() {
        if (!word("normal", "after 'facet'")) {
            return false;
        }
        for (int axis = 0; axis < 3; ++axis) {
            p_ = skip_space(p_, end_);
            const char* word_end = skip_word(p_, end_);
            if (p_ == word_end || !passes_for_number({p_, static_cast<std::size_t>(word_end - p_)})) {
                return fail("expected a number of the normal, found " + found());
            }
            p_ = word_end;
        }
        return true;
    }

    bool vertex(float* xyz) {
        return word("vertex", "(a facet has three)") && number(xyz[0]) && number(xyz[1]) && number(xyz[2]);
    }

    bool number(float& value) {
        p_ = skip_space(p_, end_);
        if (p_ == end_) {
            return fail("expected a coordinate, found the end of the file");
        }
        const NumberText got = read_number(p_, end_, value);
        return got == NumberText::read || fail(coordinate_problem(got, "float", found()));
    }

    [[gnu::always_inline]] bool word(const Keyword& keyword, const char* place) {
        p_ = skip_space(p_, end_);
        if (!is_word(p_, end_, keyword)) {
            return fail("expected '" + std::string(keyword.text) + "' " + place + ", found " + found());
        }
        p_ += keyword.text.size();
        return true;
    }

    bool fail(std::string what) {
        failure_ = {p_, std::move(what)};
        return false;
    }

    std::string found() const { return word_at(p_, end_); }

    static constexpr int most_words = 16;  // that are skipped in a facet

    const char* p_;
    const char* end_;
    StopPace pace_;
    Facets& facets_;
    TextError failure_;
};

/// Each piece but the first begins with a facet at the begin of a line, where no name reaches.
std::vector<TextPiece> cut_at_facets(std::string_view text) {
    const char* const end = text.data() + text.size();
    return cut_text(text, text_piece_bytes, [end](const char*, const char* p) {
        do {
            p = skip_space(skip_line(p, end), end);
        } while (p != end && !may_begin_facet(p, end));
        return p;
    });
}

/// Words are read to the end of the text, so that a cut never looks like the end.
std::vector<Facets> parse_facets(std::string_view text, const Parallel& parallel) {
    const std::vector<TextPiece> pieces = cut_at_facets(text);
    std::vector<Facets> facets(pieces.size());
    parse_pieces(pieces.size(), parallel, [&](std::size_t i, int) {
        Facets own{ChunkList<std::byte, 16 * facet_bytes, 512 * facet_bytes>(parallel.memory())};
        FacetParser(pieces[i].begin(), text.data() + text.size(), parallel, own).parse(pieces[i].end());
        facets[i] = std::move(own);
    });
    return facets;
}

/// Writes spaces over the NUL bytes, and says so in a warning. An error where they are within words other than those of a
/// name, as what they replace is then unknown.
void blank_nuls(FileContents& file, std::vector<std::string>& warnings) {
    const std::string_view text = file.whole;
    const char* const text_end = text.data() + text.size();
    StopPace pace = pace_of(file.source.parallel());
    std::size_t count = 0;
    std::size_t line_end = 0;
    const char* word = nullptr;  // the line's first, or white space before it
    const std::size_t first = text.find('\0');
    for (std::size_t begin = first; begin != std::string_view::npos; begin = text.find('\0', begin)) {
        const std::size_t end = std::min(text.find_first_not_of('\0', begin), text.size());
        pace.spend(step_work);
        if (begin >= line_end) {
            word = text.data() + (text.find_last_of("\r\n", begin) + 1);  // 0 where there is no line before
            line_end = std::min(text.find_first_of("\r\n", begin), text.size());
        }
        word = skip_space(word, text_end);
        const bool between = (begin == 0 || is_space(text[begin - 1])) && (end == text.size() || is_space(text[end]));
        if (!between && !is_one_of(word, text_end, {"solid", "endsolid"})) {
            throw TextError{text.data() + begin, "a NUL byte within a word of an ASCII STL file: what stood there is lost"};
        }
        std::fill_n(file.bytes.data() + begin, end - begin, std::byte{' '});
        count += end - begin;
    }
    warnings.push_back(file.source.name() + ": is an ASCII STL file with " + counted(count, "NUL byte") +
                       ", read as spaces, the first in line " + std::to_string(line_of(text, first)));
}

/// Beyond the sample, NUL bytes are looked for only where something is wrong.
std::vector<Facets> facets_of(FileContents& file, std::vector<std::string>& warnings) {
    const FileSource& source = file.source;
    if (is_text(source.sample())) {
        try {
            return parse_facets(file.text, source.parallel());
        } catch (const TextError&) {
            if (file.text.find('\0') == std::string_view::npos) {
                throw;
            }
        }
    }
    blank_nuls(file, warnings);
    return parse_facets(file.text, source.parallel());
}

void warn_of_departures(const FileContents& file, const std::vector<Facets>& facets, std::vector<std::string>& warnings) {
    const std::string& name = file.source.name();
    LeftOut odd;
    LeftOut lines;
    std::string first_odd;
    for (const Facets& piece : facets) {
        first_odd = odd.count == 0 ? piece.first_odd : first_odd;
        odd.add(piece.odd);
        lines.add(piece.lines);
    }
    if (odd.count > 0) {
        warnings.push_back(name + ": read " + counted(odd.count, "facet") + " by the vertices alone" +
                           first_line_words(odd, file.whole) + ": " + first_odd);
    }
    if (lines.count > 0) {
        warnings.push_back(name + ": ignored " + counted(lines.count, "line") + " between facets" +
                           first_word_words(lines, file.whole));
    }
    if (const char* const end = facets.back().open_end; end != nullptr) {
        const std::size_t line = line_of(file.text, static_cast<std::size_t>(end - file.text.data()));
        warnings.push_back(name + ": ends without 'endsolid' after line " + std::to_string(line) +
                           ": what follows may have been cut off");
    }
}

}  // namespace

void parse_ascii_stl(FileContents& file, MeshFile& mesh) {
    std::vector<Facets> facets = facets_of(file, mesh.warnings);
    PartMarks solids;
    std::vector<std::uint64_t> first;
    first.reserve(facets.size());
    for (const Facets& piece : facets) {
        add_marks(solids, piece.solids, mesh.triangle_count);
        first.push_back(mesh.triangle_count);
        mesh.triangle_count += piece.count();
    }
    if (mesh.triangle_count == 0) {
        const auto odd =
            std::find_if(facets.begin(), facets.end(), [](const Facets& piece) { return piece.lines.count > 0; });
        if (odd != facets.end()) {
            throw TextError{odd->lines.first, "expected 'facet', 'solid' or 'endsolid', found " +
                                                  word_at(odd->lines.first, file.whole.data() + file.whole.size())};
        }
        file.source.refuse(ErrorCode::empty_mesh, "holds no triangles");
    }
    mesh.stride = facet_bytes;
    mesh.text = true;
    mesh.bytes = Array<std::byte>(file.source.memory());
    mesh.bytes.resize_discarding(mesh.triangle_count * facet_bytes);
    file.source.parallel().run(facets.size(), [&](std::size_t i, int) {
        facets[i].coordinates.move_to(mesh.bytes.data() + first[i] * facet_bytes);
    });
    give_parts(solids, false, file.source.name(), mesh);
    give_stated_frame(file.text.substr(0, file.text.find_first_of("\r\n")), file.source, mesh);
    warn_of_departures(file, facets, mesh.warnings);
}

}  // namespace lamella
