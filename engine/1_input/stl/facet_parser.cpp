#include "1_input/stl/facet_parser.hpp"

#include <algorithm>
#include <string_view>

namespace lamella {

namespace {

bool is_number_character(char c) {
    return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
}

/// A component of a normal: digits, or how some C library spells what is not a number ("-nan(ind)", "1.#QNAN", "inf").
/// Normals are not used, so that no more is asked of them.
bool passes_for_number(std::string_view word) {
    if (std::all_of(word.begin(), word.end(), is_number_character)) {
        return true;
    }
    std::string lower(word.substr(0, 16));
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return static_cast<char>(c | 0x20); });
    return lower.find("nan") != std::string::npos || lower.find("inf") != std::string::npos ||
           lower.find(".#") != std::string::npos;
}

}  // namespace

bool FacetParser::fail(const std::string& what) {
    failure_ = {p_, what};
    return false;
}

template <Keyword keyword>
inline bool FacetParser::word(const char* place) {
    p_ = skip_space(p_, end_);
    if (!is_word<keyword>(p_, end_)) {
        return fail(std::string("expected '") + keyword.text + "' " + place + ", found " + found());
    }
    p_ += keyword.length;
    return true;
}

bool FacetParser::next_facet(const char* stop, float* nine) {
    for (p_ = skip_space(p_, end_); p_ < stop; p_ = skip_space(p_, end_)) {
        if (is_word<"facet">(p_, end_)) {
            return facet(nine);
        }
        if (!is_word<"solid">(p_, end_) && !is_word<"endsolid">(p_, end_)) {
            return fail("expected 'facet', 'solid' or 'endsolid', found " + found());
        }
        p_ = skip_line(p_, end_);
    }
    return false;
}

bool FacetParser::facet(float* nine) {
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
            return fail("expected a number of the normal, found " + found());
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
        return fail("expected a coordinate, found the end of the file");
    }
    const NumberText got = read_number(p_, end_, value);
    return got == NumberText::read || fail(coordinate_problem(got, "float", found()));
}

}  // namespace lamella
