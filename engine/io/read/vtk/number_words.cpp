#include "io/read/vtk/number_words.hpp"

#include <algorithm>
#include <charconv>
#include <type_traits>

namespace lamella {

namespace {

constexpr std::size_t word_piece_bytes = std::size_t{256} << 10;

/// Few numbers with the space after them are longer. The first window of a run is cut by this, so that little text beyond
/// the run is counted.
constexpr std::uint64_t usual_word_bytes = 12;

/// To the end of the next `count` words, which exist.
const char* skip_words(const char* p, const char* end, std::uint64_t count) {
    for (; count > 0; --count) {
        p = skip_word(skip_space(p, end), end);
    }
    return p;
}

/// Cuts [p, end) after words and counts those of each piece.
std::vector<TextPiece> cut_window(const char* p, const char* end, const Parallel& parallel) {
    std::vector<TextPiece> pieces = cut_text({p, static_cast<std::size_t>(end - p)}, word_piece_bytes,
                                             [end](const char*, const char* from) { return skip_word(from, end); });
    parallel.run(pieces.size(), [&](std::size_t i, int) { pieces[i].count = count_words(pieces[i].text); });
    return pieces;
}

bool read_word(const char*& p, const char* end, std::floating_point auto& value, BadWord& bad) {
    bad.why = read_number(p, end, value);
    return bad.why == NumberText::read;
}

template <std::unsigned_integral Value>
bool read_word(const char*& p, const char* end, Value& value, BadWord& /*bad*/) {
    constexpr std::ptrdiff_t surely_exact = 9;  // digits, of any type
    std::uint64_t number = 0;
    const char* word_end = read_digits(p, end, number);
    value = static_cast<Value>(number);
    if (word_end - p > surely_exact) {
        const std::from_chars_result got = std::from_chars(p, end, value);
        if (got.ec != std::errc()) {
            return false;
        }
    }
    if (word_end == p || (word_end != end && !is_space(*word_end))) {
        return false;
    }
    p = word_end;
    return true;
}

}  // namespace

WordRun find_words(const char* p, const char* end, std::uint64_t count, const Parallel& parallel) {
    WordRun run;
    run.end = p;
    run.text_end = end;
    while (run.count < count && p != end) {
        const auto left = static_cast<std::uint64_t>(end - p);
        const std::uint64_t wanted = std::min(count - run.count, left);
        const std::uint64_t window = std::min(left, wanted * usual_word_bytes);
        const char* const window_end = skip_word(p + window, end);
        for (TextPiece& piece : cut_window(p, window_end, parallel)) {
            piece.first = run.count;
            piece.count = std::min<std::size_t>(piece.count, count - run.count);
            run.count += piece.count;
            if (piece.count > 0) {
                run.pieces.push_back(piece);
            }
        }
        p = window_end;
    }
    if (!run.pieces.empty()) {
        run.end = skip_words(run.pieces.back().begin(), end, run.pieces.back().count);
    }
    return run;
}

const char* find_word(const char* p, const char* end, std::uint64_t index) {
    p = skip_space(p, end);
    for (; index > 0 && p != end; --index) {
        p = skip_space(skip_word(p, end), end);
    }
    return p;
}

template <class Value>
BadWord read_words(const WordRun& run, Value* out, const Parallel& parallel) {
    return parse_pieces<BadWord>(run.pieces.size(), parallel, [&](std::size_t i, int) {
        const TextPiece& piece = run.pieces[i];
        BadWord bad;
        const char* p = piece.begin();
        for (std::size_t word = piece.first; word < piece.end_item(); ++word) {
            p = skip_space(p, run.text_end);
            if (!read_word(p, run.text_end, out[word], bad)) {
                bad.at = p;
                break;
            }
        }
        return bad;
    });
}

template BadWord read_words(const WordRun&, float*, const Parallel&);
template BadWord read_words(const WordRun&, double*, const Parallel&);
template BadWord read_words(const WordRun&, std::uint32_t*, const Parallel&);
template BadWord read_words(const WordRun&, std::uint64_t*, const Parallel&);

}  // namespace lamella
