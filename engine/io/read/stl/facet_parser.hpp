// The words of ASCII STL and a parser that goes from facet to facet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "base/little_endian.hpp"
#include "io/read/lookout.hpp"
#include "io/read/part_marks.hpp"
#include "io/text/lines.hpp"
#include "io/text/pieces.hpp"
#include "io/text/text.hpp"

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

/// Whether the text at `p` is `keyword`, in any case, and ends there.
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

/// What a piece of text holds that is not as the format says, and is read all the same.
struct StlDepartures {
    LeftOut facets;           ///< with an unusable normal, or without a word other than `facet` and `vertex`
    LeftOut lines;            ///< between facets, skipped
    std::string first_facet;  ///< what is wrong with it
};

/// Whether a facet may begin at `p`, by two words: `facet` may be one of a name or of a comment.
bool may_begin_facet(const char* p, const char* end);

/// Reads facets from [begin, end) up to the first error, which failure() holds.
class FacetParser {
public:
    FacetParser(const char* begin, const char* end, const Parallel& parallel) : p_(begin), end_(end), lookout_(parallel) {}

    /// The nine coordinates of the next facet that begins before `stop`. False: there is none, or failure() holds an error.
    bool next_facet(const char* stop, float* nine);

    const TextFailure& failure() const { return failure_; }
    const StlDepartures& departures() const { return departures_; }
    const PartMarks& solids() const { return solids_; }

    /// Whether the last statement was `endsolid`, and where the last one ended.
    bool solid_ended() const { return solid_ended_; }
    const char* last_end() const { return last_end_; }

private:
    const char* name_end();
    bool other_line(TextFailure& skipped);
    bool facet(float* nine);
    bool strict_facet(float* nine);
    bool sloppy_facet(float* nine);
    bool normal();
    bool vertex(float* xyz);
    bool number(float& value);
    template <Keyword keyword>
    bool word(const char* place);
    template <class What>
    bool fail(const What& what);
    std::string found() const { return word_at(p_, end_); }

    const char* p_;
    const char* end_;
    Lookout lookout_;
    const char* last_end_ = nullptr;
    bool solid_ended_ = false;
    bool silent_ = false;  // failures are without words
    TextFailure failure_;
    StlDepartures departures_;
    PartMarks solids_;
    std::uint64_t facets_ = 0;  // read so far
};

}  // namespace lamella
