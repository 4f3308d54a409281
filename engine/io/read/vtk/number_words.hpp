// Runs of numbers in text, parsed in parallel. The words are counted first, so that memory is taken for what is there.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "base/parallel.hpp"
#include "io/text/pieces.hpp"
#include "io/text/text.hpp"

namespace lamella {

/// Words that follow each other in a text.
struct WordRun {
    std::vector<TextPiece> pieces;  ///< each begins with space or with a word, and has words
    std::uint64_t count = 0;
    const char* end = nullptr;       ///< after the last word
    const char* text_end = nullptr;  ///< words are read up to there, across cuts
};

/// The next `count` words of [p, end), or as many as there are. O(the text that they take). Precondition: `p` is
/// not within a word.
WordRun find_words(const char* p, const char* end, std::uint64_t count, const Parallel& parallel);

/// The word of that index in [p, end), or `end`.
const char* find_word(const char* p, const char* end, std::uint64_t index);

/// The first word that is no number of the wanted type; `at` is null where all are.
struct BadWord {
    const char* at = nullptr;
    NumberText why = NumberText::malformed;
};

/// Integers must not be negative.
template <class Value>
BadWord read_words(const WordRun& run, Value* out, const Parallel& parallel);

extern template BadWord read_words(const WordRun&, float*, const Parallel&);
extern template BadWord read_words(const WordRun&, double*, const Parallel&);
extern template BadWord read_words(const WordRun&, std::uint32_t*, const Parallel&);
extern template BadWord read_words(const WordRun&, std::uint64_t*, const Parallel&);

}  // namespace lamella
