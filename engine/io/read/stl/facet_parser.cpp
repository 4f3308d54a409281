#include "io/read/stl/facet_parser.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

namespace lamella {

namespace {

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

/// Whether `facet normal N N N outer` begins at `p`: `facet normal` alone may be words of a name.
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

/// Whether a facet goes on with the word at `p`.
bool is_word_in_facet(const char* p, const char* end) {
    return is_word<"normal">(p, end) || is_word<"outer">(p, end) || is_word<"loop">(p, end) || is_word<"vertex">(p, end) ||
           is_word<"endloop">(p, end) || is_word<"endfacet">(p, end);
}

/// Whether the text ends within the first word of a statement.
bool is_cut_off(const char* p, const char* end) {
    const std::string_view word(p, static_cast<std::size_t>(end - p));
    return std::string_view("facet").starts_with(word) || std::string_view("endsolid").starts_with(word) ||
           std::string_view("solid").starts_with(word);
}

bool is_statement(const char* p, const char* end) {
    return is_word<"facet">(p, end) || is_word<"solid">(p, end) || is_word<"endsolid">(p, end);
}

}  // namespace

bool may_begin_facet(const char* p, const char* end) {
    if (!is_word<"facet">(p, end)) {
        return false;
    }
    p = skip_space(skip_word(p, end), end);
    return is_word<"normal">(p, end) || is_word<"outer">(p, end) || is_word<"vertex">(p, end);
}

/// With the words of what().
template <class What>
bool FacetParser::fail(const What& what) {
    failure_ = {p_, silent_ ? std::string() : what()};
    return false;
}

template <Keyword keyword>
inline bool FacetParser::word(const char* place) {
    p_ = skip_space(p_, end_);
    if (!is_word<keyword>(p_, end_)) {
        return fail([&] { return std::string("expected '") + keyword.text + "' " + place + ", found " + found(); });
    }
    p_ += keyword.length;
    return true;
}

bool FacetParser::next_facet(const char* stop, float* nine) {
    TextFailure skipped;  // the line right before
    for (p_ = skip_space(p_, end_); p_ < stop; p_ = skip_space(p_, end_)) {
        if (!is_statement(p_, end_)) {
            if (!other_line(skipped)) {
                return false;
            }
            continue;
        }
        skipped = {};
        solid_ended_ = is_word<"endsolid">(p_, end_);
        if (is_word<"facet">(p_, end_)) {
            const bool read = facet(nine);
            facets_ += read ? 1 : 0;
            last_end_ = p_;
            return read;
        }
        const char* const name = skip_word(p_, end_);
        p_ = last_end_ = name_end();
        if (!solid_ended_) {
            add_mark(solids_, facets_, false, name, p_);
        }
    }
    return false;
}

/// Skips a line that is no statement, as a comment is. False where facets would be lost: they begin within it, it stands in
/// the place of a facet's first line, which `skipped` then tells, or the file is cut off there.
bool FacetParser::other_line(TextFailure& skipped) {
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
        failure_ = skipped;
        return false;
    }
    departures_.lines.add(p_);
    p_ = line_end;
    return true;
}

/// The end of the name after `solid` or `endsolid`: the line's end, or where a facet begins on the same line.
const char* FacetParser::name_end() {
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

bool FacetParser::facet(float* nine) {
    const char* const begin = p_;
    silent_ = departures_.facets.count > 0;  // words take longer than facets, and most departures are alike
    if (strict_facet(nine)) {
        return true;
    }
    TextFailure failure = std::exchange(failure_, {});
    p_ = begin;
    if (sloppy_facet(nine)) {
        if (departures_.facets.count == 0) {
            departures_.first_facet = std::move(failure.what);
        }
        departures_.facets.add(failure.at);
        return true;
    }
    p_ = begin;
    silent_ = false;
    return strict_facet(nine);
}

/// A facet by its vertices: what the normal should be is skipped, as are words after `endloop`, and `outer loop` and
/// `endfacet` may be absent.
bool FacetParser::sloppy_facet(float* nine) {
    constexpr int most_words = 16;
    p_ = skip_space(skip_word(p_, end_), end_);
    for (int words = 0; !is_word<"vertex">(p_, end_); ++words) {
        if (words == most_words || is_statement(p_, end_) || is_word<"endloop">(p_, end_) || is_word<"endfacet">(p_, end_)) {
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

bool FacetParser::strict_facet(float* nine) {
    return word<"facet">("") && normal() && word<"outer">("after the normal") && word<"loop">("after 'outer'") &&
           vertex(nine) && vertex(nine + 3) && vertex(nine + 6) && word<"endloop">("after three vertices") &&
           word<"endfacet">("after 'endloop'");
}

bool FacetParser::normal() {
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

bool FacetParser::vertex(float* xyz) {
    return word<"vertex">("(a facet has three)") && number(xyz[0]) && number(xyz[1]) && number(xyz[2]);
}

bool FacetParser::number(float& value) {
    p_ = skip_space(p_, end_);
    if (p_ == end_) {
        return fail([] { return std::string("expected a coordinate, found the end of the file"); });
    }
    const NumberText got = read_number(p_, end_, value);
    return got == NumberText::read || fail([&] { return coordinate_problem(got, "float", found()); });
}

}  // namespace lamella
