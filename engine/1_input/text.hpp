// Words and numbers in text files, for all readers of such.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>

#include <fast_float/fast_float.h>

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

/// To the end of the line that `p` is in.
inline const char* skip_line(const char* p, const char* end) {
    while (p != end && !ends_line(*p)) {
        ++p;
    }
    return p;
}

/// The word at `p` in quotes, shortened and printable, or "the end of the file": for messages.
std::string word_at(const char* p, const char* end);

/// The line that byte `offset` is in, from 1.
std::size_t line_of(std::string_view text, std::size_t offset);

enum class NumberText { read, malformed, not_finite };

/// Reads the finite number that is the word at `p`, and moves `p` behind it. A leading + is allowed; what is too small for
/// the type is 0. Precondition: p != end and no space is at `p`.
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
