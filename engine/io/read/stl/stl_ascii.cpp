#include "io/read/stl/stl_ascii.hpp"

#include <cassert>

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

    void facet(float* nine) {
        const char* const begin = p_;
        silent_ = departures_.facets.count > 0;  // words take longer than facets, and most departures are alike
        if (strict_facet(nine)) {
            return;
        }
        TextError failure = std::exchange(failure_, {});
        p_ = begin;
        if (sloppy_facet(nine)) {
            if (departures_.facets.count == 0) {
                departures_.first_facet = std::move(failure.what);
            }
            departures_.facets.add(failure.at);
            return;
        }
        p_ = begin;
        silent_ = false;
        strict_facet(nine);
        throw failure_;
    }

    bool strict_facet(float* nine) {
        return word<"facet">("") && normal() && word<"outer">("after the normal") && word<"loop">("after 'outer'") &&
               vertex(nine) && vertex(nine + 3) && vertex(nine + 6) && word<"endloop">("after three vertices") &&
               word<"endfacet">("after 'endloop'");
    }

    /// A facet by its vertices: what the normal should be is skipped, as are words after `endloop`, and `outer loop` and
    /// `endfacet` may be absent.
    bool sloppy_facet(float* nine) {
        constexpr int most_words = 16;
        p_ = skip_space(skip_word(p_, end_), end_);
        for (int words = 0; !is_word<"vertex">(p_, end_); ++words) {
            if (words == most_words || is_statement(p_, end_) || is_word<"endloop">(p_, end_) ||
                is_word<"endfacet">(p_, end_)) {
                return false;
            }
            p_ = skip_space(skip_word(p_, end_), end_);
        }
        if (!vertex(nine) || !vertex(nine + 3) || !vertex(nine + 6)) {
            return false;
        }
        p_ = skip_space(p_, end_);
        if (!is_word<"endloop">(p_, end_)) {
            return false;
        }
        p_ = skip_space(skip_word(p_, end_), end_);
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
                return fail([&] { return "expected a number of the normal, found " + found(); });
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
            return fail([] { return std::string("expected a coordinate, found the end of the file"); });
        }
        const NumberText got = read_number(p_, end_, value);
        return got == NumberText::read || fail([&] { return coordinate_problem(got, "float", found()); });
    }

    template <Keyword keyword>
    bool word(const char* place) {
        p_ = skip_space(p_, end_);
        if (!is_word<keyword>(p_, end_)) {
            return fail([&] { return std::string("expected '") + keyword.text + "' " + place + ", found " + found(); });
        }
        p_ += keyword.length;
        return true;
    }

    /// With the words of what().
    template <class What>
    bool fail(const What& what) {
        failure_ = {p_, silent_ ? std::string() : what()};
        return false;
    }

    std::string found() const { return word_at(p_, end_); }

    const char* p_;
    const char* end_;
    Lookout lookout_;
    const char* last_end_ = nullptr;
    bool solid_ended_ = false;
    bool silent_ = false;  // failures are without words
    TextError failure_;    // of strict_facet()
    StlDepartures departures_;
    PartMarks solids_;
    std::uint64_t facets_ = 0;  // read so far
};

// --- all facets

constexpr std::size_t facet_floats = 9;
constexpr std::size_t facet_bytes = facet_floats * sizeof(float);
constexpr std::size_t shortest_facet = sizeof "facet vertex 0 0 0 vertex 0 0 0 vertex 0 0 0" - 1;

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

/// Words in 'f': all facets and, at most, some words of names.
std::size_t most_facets(std::string_view piece) {
    const auto is_f = [](char c) { return (c | 0x20) == 'f'; };
    const std::size_t words = (is_f(piece[0]) ? 1 : 0) + count_in(piece, [is_f](char before, char c) {
                                  return static_cast<int>(is_f(c)) & static_cast<int>(is_space(before));
                              });
    return std::min(words, piece.size() / shortest_facet + 1);
}

/// The facets of a piece of text.
struct FacetPiece {
    ItemRun run;
    StlDepartures departures;
    PartMarks solids;
    const char* open_end = nullptr;  // after the last statement, if that is not `endsolid`
};

/// Parses what begins within the piece, which has room for `piece.count` facets from `piece.first` on. Words are read to the
/// end of the text, so that a cut never looks like the end.
FacetPiece parse(const TextPiece& piece, const char* text_end, std::byte* coordinates, const Parallel& parallel) {
    FacetParser parser(piece.begin(), text_end, parallel);
    std::byte* out = coordinates + piece.first * facet_bytes;
    float facet[facet_floats];
    std::size_t count = 0;
    while (parser.next_facet(piece.end(), facet)) {
        assert(count < piece.count);
        std::memcpy(out + count++ * facet_bytes, facet, facet_bytes);
    }
    return {{piece.first, count}, parser.departures(), parser.solids(), parser.solid_ended() ? nullptr : parser.last_end()};
}

}  // namespace

AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel) {
    AsciiFacets facets{Array<std::byte>(memory), 0, {}, {}, nullptr};
    std::vector<TextPiece> pieces = cut_at_facets(text, parallel);
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].count = most_facets(pieces[i].text); });
    facets.coordinates.resize_discarding(number_items(pieces) * facet_bytes);

    std::vector<FacetPiece> parsed(pieces.size());
    parse_pieces(pieces.size(), parallel, [&](std::size_t i, int) {
        parsed[i] = parse(pieces[i], text.data() + text.size(), facets.coordinates.data(), parallel);
    });
    std::vector<ItemRun> runs;
    std::uint64_t first = 0;
    for (const FacetPiece& piece : parsed) {
        add_marks(facets.solids, piece.solids, first);
        first += piece.run.count;
        runs.push_back(piece.run);
        facets.open_end = piece.open_end;
        if (facets.departures.facets.count == 0) {
            facets.departures.first_facet = piece.departures.first_facet;
        }
        facets.departures.facets.add(piece.departures.facets);
        facets.departures.lines.add(piece.departures.lines);
    }
    // Words of names in 'f' left gaps; there are none otherwise.
    facets.count = close_gaps(runs, facet_bytes, facets.coordinates.data());
    facets.coordinates.set_size(facets.count * facet_bytes);
    return facets;
}

}  // namespace lamella
