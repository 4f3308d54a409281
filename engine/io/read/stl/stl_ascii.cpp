#include "io/read/stl/stl_ascii.hpp"

#include "io/read/chunk_list.hpp"

namespace lamella {

namespace {

// --- a facet

bool is_number_character(char c) {
    return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
}

/// A component of a normal: digits, or how some C library spells what is not a number ("-nan(ind)", "1.#QNAN", "inf").
/// Normals are not used, so they are not parsed.
bool passes_for_number(std::string_view word) {
    if (std::all_of(word.begin(), word.end(), is_number_character)) {
        return true;
    }
    const std::string lower = lower_case(word.substr(0, 16));
    return lower.find("nan") != std::string::npos || lower.find("inf") != std::string::npos ||
           lower.find(".#") != std::string::npos;
}

/// True if `facet normal N N N outer` begins at `p`: `facet normal` alone may be words of a name.
bool begins_facet(const char* p, const char* end) {
    if (!is_word<"facet">(p, end)) {
        return false;
    }
    p = skip_space(skip_word(p, end), end);
    if (!is_word<"normal">(p, end)) {
        return false;
    }
    for (int word = 0; word < 4; ++word) {
        p = skip_space(skip_word(p, end), end);
    }
    return is_word<"outer">(p, end);
}

/// True if a facet goes on with the word at `p`.
bool is_word_in_facet(const char* p, const char* end) {
    return is_word<"normal">(p, end) || is_word<"outer">(p, end) || is_word<"loop">(p, end) || is_word<"vertex">(p, end) ||
           is_word<"endloop">(p, end) || is_word<"endfacet">(p, end);
}

/// True if the text ends within the first word of a statement.
bool is_cut_off(const char* p, const char* end) {
    const std::string_view word(p, static_cast<std::size_t>(end - p));
    return std::string_view("facet").starts_with(word) || std::string_view("endsolid").starts_with(word) ||
           std::string_view("solid").starts_with(word);
}

bool is_statement(const char* p, const char* end) {
    return is_word<"facet">(p, end) || is_word<"solid">(p, end) || is_word<"endsolid">(p, end);
}

/// True if a facet may begin at `p`, by two words: `facet` may be one of a name or of a comment.
bool may_begin_facet(const char* p, const char* end) {
    if (!is_word<"facet">(p, end)) {
        return false;
    }
    p = skip_space(skip_word(p, end), end);
    return is_word<"normal">(p, end) || is_word<"outer">(p, end) || is_word<"vertex">(p, end);
}

/// Reads facets from [begin, end) one after the other.
class FacetParser {
public:
    FacetParser(const char* begin, const char* end, const Parallel& parallel) : p_(begin), end_(end), lookout_(parallel) {}

    /// The nine coordinates of the next facet that begins before `stop`. False: there is none. Throws TextError.
    bool next_facet(const char* stop, float* nine) {
        TextError skipped;  // the line right before
        for (p_ = skip_space(p_, end_); p_ < stop; p_ = skip_space(p_, end_)) {
            if (!is_statement(p_, end_)) {
                other_line(skipped);
                continue;
            }
            skipped = {};
            solid_ended_ = is_word<"endsolid">(p_, end_);
            if (is_word<"facet">(p_, end_)) {
                facet(nine);
                ++facets_;
                last_end_ = p_;
                return true;
            }
            const char* const name = skip_word(p_, end_);
            p_ = last_end_ = name_end();
            if (!solid_ended_) {
                add_mark(solids_, facets_, false, name, p_);
            }
        }
        return false;
    }

    const StlDepartures& departures() const { return departures_; }
    const PartMarks& solids() const { return solids_; }

    /// True if the last statement was `endsolid`, and where the last one ended.
    bool solid_ended() const { return solid_ended_; }
    const char* last_end() const { return last_end_; }

private:
    /// The end of the name after `solid` or `endsolid`: the line's end, or where a facet begins on the same line.
    const char* name_end() {
        const char* p = skip_word(p_, end_);
        while (p != end_ && !ends_line(*p)) {
            lookout_.pass();
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
        bool harmless = !is_word_in_facet(p_, end_) && !is_cut_off(p_, end_) &&
                        std::memchr(p_, '\0', static_cast<std::size_t>(line_end - p_)) == nullptr;
        for (const char* p = p_; harmless && p < line_end; p = skip_space(skip_word(p, end_), end_)) {
            lookout_.pass();
            harmless = !may_begin_facet(p, end_);
        }
        if (skipped.at == nullptr) {
            skipped = {p_, "expected 'facet', 'solid' or 'endsolid', found " + found()};
        }
        if (!harmless) {
            throw skipped;
        }
        departures_.lines.add(p_);
        p_ = line_end;
    }

    /// What the normal should be is skipped where it is none, as are words after `endloop`; `outer loop` and `endfacet` may
    /// be absent. The first of several departures is the one that is reported.
    void facet(float* nine) {
        const char* const begin = p_ = skip_word(p_, end_);
        std::optional<TextError> departure;
        const auto depart = [&](bool read_all_the_same) {
            departure = departure ? departure : failure_;
            if (!read_all_the_same) {
                throw *departure;
            }
        };
        if (!normal() || !word<"outer">("after the normal") || !word<"loop">("after 'outer'")) {
            p_ = begin;
            depart(skip_to_vertex());
        }
        if (!vertex(nine) || !vertex(nine + 3) || !vertex(nine + 6) || !word<"endloop">("after three vertices")) {
            depart(false);
        }
        if (!word<"endfacet">("after 'endloop'")) {
            depart(skip_to_end());
        }
        if (departure) {
            departures_.first_facet = departures_.facets.count == 0 ? departure->what : departures_.first_facet;
            departures_.facets.add(departure->at);
        }
    }

    bool skip_to_vertex() {
        for (int words = 0;; ++words) {
            p_ = skip_space(p_, end_);
            if (is_word<"vertex">(p_, end_)) {
                return true;
            }
            if (words == most_words || is_statement(p_, end_) || is_word<"endloop">(p_, end_) ||
                is_word<"endfacet">(p_, end_) || p_ == end_) {
                return false;
            }
            p_ = skip_word(p_, end_);
        }
    }

    /// To the end of the facet, or where the next statement begins.
    bool skip_to_end() {
        p_ = skip_space(p_, end_);
        for (int words = 0; words < most_words && p_ != end_ && !is_statement(p_, end_); ++words) {
            if (is_word_in_facet(p_, end_)) {
                const bool ends = is_word<"endfacet">(p_, end_);
                p_ = ends ? skip_word(p_, end_) : p_;
                return ends;
            }
            p_ = skip_space(skip_word(p_, end_), end_);
        }
        return is_statement(p_, end_);
    }

    bool normal() {
        if (!word<"normal">("after 'facet'")) {
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
        return word<"vertex">("(a facet has three)") && number(xyz[0]) && number(xyz[1]) && number(xyz[2]);
    }

    bool number(float& value) {
        p_ = skip_space(p_, end_);
        if (p_ == end_) {
            return fail("expected a coordinate, found the end of the file");
        }
        const NumberText got = read_number(p_, end_, value);
        return got == NumberText::read || fail(coordinate_problem(got, "float", found()));
    }

    template <Keyword keyword>
    bool word(const char* place) {
        p_ = skip_space(p_, end_);
        if (!is_word<keyword>(p_, end_)) {
            return fail(std::string("expected '") + keyword.text + "' " + place + ", found " + found());
        }
        p_ += keyword.length;
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
    Lookout lookout_;
    const char* last_end_ = nullptr;
    bool solid_ended_ = false;
    TextError failure_;
    StlDepartures departures_;
    PartMarks solids_;
    std::uint64_t facets_ = 0;  // read so far
};

// --- all facets

constexpr std::size_t facet_floats = 9;
constexpr std::size_t facet_bytes = facet_floats * sizeof(float);

/// True if [line, p) holds `solid` or `endsolid` as a word: what follows on the line is then a name.
bool names_something(const char* line, const char* p) {
    while ((line = skip_space(line, p)) != p) {
        if (is_word<"solid">(line, p) || is_word<"endsolid">(line, p)) {
            return true;
        }
        line = skip_word(line, p);
    }
    return false;
}

/// The first facet that begins at or after `from`, or `end`. `known` < from is the beginning of a facet or of the text: no
/// name reaches across it, so the search back stops there and all cuts together take O(text).
const char* next_facet(const char* known, const char* from, const char* end, const Parallel& parallel) {
    for (const char* p = from; p != end; ++p) {
        if ((p - from) % static_cast<std::ptrdiff_t>(text_piece_bytes) == 0) {
            parallel.stop_if_asked();
        }
        if (!may_begin_facet(p, end) || !is_space(p[-1])) {
            continue;
        }
        const char* line = p;
        while (line != known && !ends_line(line[-1])) {
            --line;
        }
        if (!names_something(line, p)) {
            return p;
        }
        p = std::find_if(p, end, ends_line);
        if (p == end) {
            break;
        }
    }
    return end;
}

/// Each piece begins with a facet (the first one: with the file) and ends where the next one begins.
std::vector<TextPiece> cut_at_facets(std::string_view text, const Parallel& parallel) {
    const char* const end = text.data() + text.size();
    return cut_text(text, text_piece_bytes, [end, &parallel](const char* begin, const char* from) {
        return next_facet(begin, from, end, parallel);
    });
}

/// The facets of a piece of text.
struct FacetPiece {
    ChunkList<std::byte, 16 * facet_bytes, 512 * facet_bytes> coordinates;
    StlDepartures departures{};
    PartMarks solids{};
    const char* open_end = nullptr;  // after the last statement, if that is not `endsolid`
};

/// Parses what begins within the piece. Words are read to the end of the text, so that a cut never looks like the end.
FacetPiece parse(const TextPiece& piece, const char* text_end, const Memory* memory, const Parallel& parallel) {
    FacetParser parser(piece.begin(), text_end, parallel);
    FacetPiece facets{ChunkList<std::byte, 16 * facet_bytes, 512 * facet_bytes>(memory)};
    float facet[facet_floats];
    while (parser.next_facet(piece.end(), facet)) {
        std::memcpy(facets.coordinates.room().data(), facet, facet_bytes);
        facets.coordinates.add(facet_bytes);
    }
    facets.departures = parser.departures();
    facets.solids = parser.solids();
    facets.open_end = parser.solid_ended() ? nullptr : parser.last_end();
    return facets;
}

}  // namespace

AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel) {
    AsciiFacets facets{Array<std::byte>(memory), 0, {}, {}, nullptr};
    const std::vector<TextPiece> pieces = cut_at_facets(text, parallel);
    std::vector<FacetPiece> parsed(pieces.size());
    parse_pieces(pieces.size(), parallel,
                 [&](std::size_t i, int) { parsed[i] = parse(pieces[i], text.data() + text.size(), memory, parallel); });
    std::vector<std::size_t> first;
    first.reserve(parsed.size());
    for (const FacetPiece& piece : parsed) {
        add_marks(facets.solids, piece.solids, facets.count);
        first.push_back(facets.count * facet_bytes);
        facets.count += piece.coordinates.size() / facet_bytes;
        facets.open_end = piece.open_end;
        if (facets.departures.facets.count == 0) {
            facets.departures.first_facet = piece.departures.first_facet;
        }
        facets.departures.facets.add(piece.departures.facets);
        facets.departures.lines.add(piece.departures.lines);
    }
    facets.coordinates.resize_discarding(facets.count * facet_bytes);
    parallel.run(parsed.size(),
                 [&](std::size_t i, int) { parsed[i].coordinates.move_to(facets.coordinates.data() + first[i]); });
    return facets;
}

}  // namespace lamella
