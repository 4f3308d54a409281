// Words and numbers in text files.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include <fast_float/fast_float.h>

#include "base/little_endian.hpp"

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

/// Of ASCII letters; other characters stay.
constexpr char lower_case(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
}
std::string lower_case(std::string_view text);

/// Whether `text` begins with `start`, given in lower case, in any case.
bool begins_in_any_case(std::string_view text, std::string_view start);

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

/// The word at `p` in quotes, shortened and printable, or "the end of the file": for messages.
std::string word_at(const char* p, const char* end);

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

}  // namespace lamella
