// ASCII STL as text in memory, parsed in parallel.
#pragma once

#include "io/read/stated.hpp"
#include "io/text/text.hpp"
#include "lamella/context.hpp"

namespace lamella {

/// A word of at most eight lower-case letters, compared as one integer.
template <std::size_t N>
struct Keyword {
    static constexpr std::size_t length = N - 1;
    static_assert(length >= 1 && length <= 8, "the word is held in 64 bits");
    std::uint64_t letters = 0;
    char text[N] = {};

    consteval Keyword(const char (&word)[N]) {  // NOLINT(google-explicit-constructor): a template argument
        for (std::size_t i = 0; i < length; ++i) {
            letters |= static_cast<std::uint64_t>(word[i]) << (8 * i);
            text[i] = word[i];
        }
    }
};

/// True if the text at `p` is `keyword`, in any case, and ends there.
template <Keyword keyword>
inline bool is_word(const char* p, const char* end) {
    constexpr std::size_t length = keyword.length;
    const auto left = static_cast<std::size_t>(end - p);
    if (left < length) {
        return false;
    }
    std::uint64_t letters = 0;
    std::memcpy(&letters, p, left < 8 ? length : 8);
    letters |= 0x2020202020202020;
    return (letters ^ keyword.letters) << (8 * (8 - length)) == 0 && (left == length || is_space(p[length]));
}

/// Departures of a piece of text from the format, which is read all the same.
struct StlDepartures {
    LeftOut facets;           ///< with an unusable normal, or without a word other than `facet` and `vertex`
    LeftOut lines;            ///< between facets, skipped
    std::string first_facet;  ///< what is wrong with it
};

struct AsciiFacets {
    Array<std::byte> coordinates;  ///< nine floats a facet
    std::size_t count = 0;
    StlDepartures departures;
    PartMarks solids;
    const char* open_end = nullptr;  ///< in the text after the last statement, if that is not `endsolid`
};

/// Grammar: any number of `solid NAME-TO-END-OF-LINE`, `endsolid NAME-TO-END-OF-LINE` and
///
///     facet normal N N N  outer loop  vertex X Y Z  vertex X Y Z  vertex X Y Z  endloop  endfacet
///
/// in any case and with any white space between words. A name ends before its line does where a facet begins. Normals are
/// skipped. Departures from the grammar that leave no doubt about the vertices are read too. Throws TextError. Time and
/// memory are O(text).
AsciiFacets parse_ascii_stl(std::string_view text, const Memory* memory, const Parallel& parallel);

}  // namespace lamella
