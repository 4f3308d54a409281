// Words and numbers in text files, and text on several threads, the same way for all readers:
//
//     cut_text()       pieces of about one size, each ending where the format lets it end
//     Parallel::run()  counts the items of each piece: vertices, lines, words or facets
//     number_items()   so that each piece knows where its items go among all
//     parse_pieces()   of the errors, the first in the text is reported
//
// Cuts depend on the text alone, so that neither results nor errors depend on threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fast_float/fast_float.h>

#include "base/little_endian.hpp"
#include "base/parallel.hpp"

namespace lamella {

constexpr bool is_space(char c) {
    return (c == ' ') | ((c >= '\t') & (c <= '\r'));
}

/// LF, CR and CRLF each end a line.
constexpr bool ends_line(char c) {
    return c == '\n' || c == '\r';
}

inline const char* skip_space(const char* p, const char* end) {
    while (p != end && is_space(*p)) {
        ++p;
    }
    return p;
}

inline const char* skip_word(const char* p, const char* end) {
    while (p != end && !is_space(*p)) {
        ++p;
    }
    return p;
}

constexpr bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// ASCII letters in lower case; other characters stay.
constexpr char lower_case(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
}
std::string lower_case(std::string_view text);

/// True if `text` begins with `start`, given in lower case, in any case.
bool begins_in_any_case(std::string_view text, std::string_view start);

/// Percent escapes, "%20", resolved.
std::string without_escapes(std::string_view text);

/// `path`, which a file gives to another one, without a leading slash; nothing if it may lead out of their folder.
std::optional<std::string> path_within(std::string_view path);

// Characters are read eight at a time: words and lines are short, and processors predict their ends wrongly.
inline std::uint64_t load_eight(const char* p) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, p, sizeof eight);
    return eight;
}

constexpr std::uint64_t eight_of(char c) {
    return 0x0101010101010101U * static_cast<unsigned char>(c);
}

/// The highest bit of each byte of `eight` that is `c`, exact up to the first one.
constexpr std::uint64_t bits_where(std::uint64_t eight, char c) {
    const std::uint64_t difference = eight ^ eight_of(c);
    return (difference - eight_of(1)) & ~difference & eight_of('\x80');
}

/// To the end of the line that `p` is in.
inline const char* skip_line(const char* p, const char* end) {
    for (; end - p >= 8; p += 8) {
        const std::uint64_t eight = load_eight(p);
        const std::uint64_t ends = bits_where(eight, '\n') | bits_where(eight, '\r');
        if (ends != 0) {
            return p + std::countr_zero(ends) / 8;
        }
    }
    while (p != end && !ends_line(*p)) {
        ++p;
    }
    return p;
}

/// Reads the decimal digits at `p` and returns where they end. Numbers beyond 10^18 are read as 10^18 or more.
inline const char* read_digits(const char* p, const char* end, std::uint64_t& number) {
    number = 0;
    if (end - p >= 2 && is_digit(p[0]) && !is_digit(p[1])) {  // the number of corners of nearly every face
        number = static_cast<std::uint64_t>(*p - '0');
        return p + 1;
    }
    if (end - p >= 8) {
        const std::uint64_t values = load_eight(p) ^ eight_of('0');
        const std::uint64_t others = ((values + eight_of('\x76')) | values) & eight_of('\x80');  // more than 9
        const int bits = std::countr_zero(others) & ~7;
        if (bits < 64) {
            // Leading zeros fill up to eight digits; then pairs of digits become numbers below 100, pairs of these numbers
            // below 10,000, and so on.
            std::uint64_t parts = bits == 0 ? 0 : values << (64 - bits);
            parts = (parts * 10 + (parts >> 8)) & 0x00FF00FF00FF00FF;
            parts = (parts * 100 + (parts >> 16)) & 0x0000FFFF0000FFFF;
            number = (parts * 10'000 + (parts >> 32)) & 0xFFFFFFFF;
            return p + bits / 8;
        }
    }
    constexpr std::uint64_t limit = 1'000'000'000'000'000'000;
    for (; p != end && is_digit(*p); ++p) {
        number = std::min(limit, 10 * number + static_cast<std::uint64_t>(*p - '0'));
    }
    return p;
}

/// True if all of `text` is one decimal integer, which `value` is then.
template <class Integer>
bool read_integer(std::string_view text, Integer& value) {
    const char* const end = text.data() + text.size();
    const auto [stop, problem] = std::from_chars(text.data(), end, value);
    return problem == std::errc() && stop == end;
}

/// The word at `p` in quotes, shortened and printable, or "the end of the file": for messages.
std::string word_at(const char* p, const char* end);

/// Text of a file in a message: "'abc'", or its beginning.
std::string in_quotes(std::string_view text);

/// A blank that readers write over line ends which end no statement, and which still ends a line in messages.
inline constexpr char joined_line_end = '\v';

/// The line that byte `offset` is in, from 1.
std::size_t line_of(std::string_view text, std::size_t offset);

enum class NumberText { read, malformed, not_finite };

/// The message for `found` in place of a finite coordinate of the type.
std::string coordinate_problem(NumberText got, const std::string& type, const std::string& found);

/// Reads the word at `p`, a finite number, and moves `p` past it. A leading + is allowed; numbers too small for the type are
/// 0. Precondition: p != end and no space is at `p`.
template <class Value>
NumberText read_number(const char*& p, const char* end, Value& value) {
    const char* digits = p;
    if (*p == '+' && end - p > 1 && p[1] != '-') {
        ++digits;  // fast_float, as std::from_chars, takes no plus sign
    }
    const fast_float::from_chars_result got = fast_float::from_chars(digits, end, value);
    // Releases differ in whether they report what is too small; what is too large is infinite.
    if (got.ec == std::errc::invalid_argument || (got.ptr != end && !is_space(*got.ptr))) {
        return NumberText::malformed;
    }
    if (!std::isfinite(value)) {
        return NumberText::not_finite;
    }
    p = got.ptr;
    return NumberText::read;
}

/// All of `text` as one finite number; a leading + is allowed.
std::optional<double> parse_number(std::string_view text) noexcept;
/// Such numbers between separators, with blanks around them or none; nothing where something else stands there.
std::optional<std::vector<double>> parse_numbers(std::string_view text, char separator);

/// Without what is in `padding` at both ends.
std::string_view trimmed(std::string_view text, std::string_view padding = " \t\r\v\f");

// --- pieces

/// A piece of text, and which of the items of the whole text are in it.
struct TextPiece {
    std::string_view text;
    std::size_t first = 0;
    std::size_t count = 0;

    const char* begin() const noexcept { return text.data(); }
    const char* end() const noexcept { return text.data() + text.size(); }
    std::size_t end_item() const noexcept { return first + count; }
};

/// Large enough to hide the cost of a task, small enough to share out.
inline constexpr std::size_t text_piece_bytes = std::size_t{1} << 20;

/// Pieces of `piece_bytes` or little more; only the last may be shorter. end_of_piece(begin, from) is where the piece from
/// `begin` ends: at `from` or after.
std::vector<TextPiece> cut_text(std::string_view text, std::size_t piece_bytes,
                                FunctionRef<const char*(const char* begin, const char* from)> end_of_piece);

/// Sets each piece's `first` by what the pieces before count. Returns how many items there are in all.
std::size_t number_items(std::span<TextPiece> pieces);

/// How many characters, all but the first, are counted by counts(character before, character): 1 or 0. In blocks whose sum
/// fits a byte, so that compilers make vectors of it and it runs at the speed of memory.
template <class Counts>
std::size_t count_in(std::string_view text, Counts counts) {
    constexpr std::size_t block = 240;
    std::size_t sum = 0;
    for (std::size_t begin = 1; begin < text.size(); begin += block) {
        const char* const before = text.data() + begin - 1;
        const std::size_t length = std::min(block, text.size() - begin);
        std::uint8_t own = 0;
        for (std::size_t i = 0; i < length; ++i) {
            own = static_cast<std::uint8_t>(own + static_cast<std::uint8_t>(counts(before[i], before[i + 1])));
        }
        sum += own;
    }
    return sum;
}

/// Words in `text`, at whose beginning a word may begin.
std::size_t count_words(std::string_view text);

/// A fault in a text, thrown by whatever reads it. The reader of the file says in which line that is.
struct TextError {
    const char* at = nullptr;
    std::string what{};
    bool has_lines = true;  ///< false: among binary data
};

/// Calls parse(piece, worker) for pieces in [0, count), in parallel. Of the failures that it throws that of the first piece
/// is thrown; pieces after one that has failed may be left out.
template <class Failure = TextError, class Parse>
void parse_pieces(std::size_t count, const Parallel& parallel, Parse parse) {
    std::mutex mutex;
    std::optional<Failure> failure;  // with `mutex` held
    std::atomic<std::size_t> first_failed{count};
    parallel.run(count, [&](std::size_t i, int worker) {
        if (i > first_failed.load(std::memory_order_relaxed)) {
            return;
        }
        try {
            parse(i, worker);
        } catch (Failure& own) {
            const std::lock_guard lock(mutex);
            if (i < first_failed) {
                first_failed = i;
                failure = std::move(own);
            }
        }
    });
    if (failure) {
        throw *std::move(failure);
    }
}

// --- Text whose statements are lines, as in OBJ and OFF

/// White space within a line.
constexpr bool is_blank(char c) {
    return (c == ' ') | (c == '\t') | (c == '\v') | (c == '\f');
}

inline const char* skip_blank(const char* p, const char* end) {
    while (p != end && is_blank(*p)) {
        ++p;
    }
    return p;
}

/// The comments and empty lines that `text` begins with.
std::string_view head_comments(std::string_view text);

/// Pieces of about 1 MB. Each one ends after a line end, or with the text.
std::vector<TextPiece> cut_at_lines(std::string_view text);

/// Items that a reader leaves out of a piece or of the whole text.
struct LeftOut {
    std::size_t count = 0;
    const char* first = nullptr;

    void add(const char* at) { add({1, at}); }
    void add(const LeftOut& other) {
        first = other.first == nullptr || (first != nullptr && first < other.first) ? first : other.first;
        count += other.count;
    }
};

/// ", the first in line 7": where in the whole text it is. Precondition: left_out.count > 0.
std::string first_line_words(const LeftOut& left_out, std::string_view text);
/// ", the first in line 7: 'abc'", with the word that is there.
std::string first_word_words(const LeftOut& left_out, std::string_view text);

/// Reads words and numbers line by line.
class LineParser {
public:
    /// Precondition: it ends right after a line end, or with the whole text.
    explicit LineParser(std::string_view text) : p_(text.data()), end_(text.data() + text.size()) {}

protected:
    /// To the next word of the line. False: there is none.
    bool to_word() {
        p_ = skip_blank(p_, end_);
        return p_ != end_ && !ends_line(*p_) && *p_ != '#';
    }

    /// To the next word, over line ends and comments. False: there is none.
    bool next_word() {
        for (p_ = skip_space(p_, end_); !to_word(); p_ = skip_space(skip_line(p_, end_), end_)) {
            if (p_ == end_) {
                return false;
            }
        }
        return true;
    }

    /// True if a word may end at `p`.
    bool word_ends(const char* p) const { return p == end_ || is_space(*p); }

    void skip_rest() { p_ = skip_line(p_, end_); }

    /// The three coordinates of a vertex, and then at most `others` numbers that are skipped, to the end of the line.
    void vertex(double* xyz, int others);
    /// The line's next word as a coordinate; what comes after it stays.
    double coordinate();
    /// Skips at most so many numbers, and then comes the end of the line. Returns how many there are.
    int other_numbers(int most);

    /// Throws a TextError at p_.
    [[noreturn]] void fail(const std::string& what) const { throw TextError{p_, what}; }
    std::string found() const;

    const char* p_;
    const char* end_;
};

}  // namespace lamella
