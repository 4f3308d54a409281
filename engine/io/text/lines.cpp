#include "io/text/lines.hpp"

namespace lamella {

namespace {

/// Right after the first line end from `from` on that no backslash precedes.
const char* next_cut(const char* from, const char* end) {
    for (const char* p = skip_line(from, end); p != end; p = skip_line(p + 1, end)) {
        // CRLF ends a line with its LF.
        if (p[-1] != '\\' && !(*p == '\r' && p + 1 != end && p[1] == '\n') &&
            !(*p == '\n' && p[-1] == '\r' && p[-2] == '\\')) {
            return p + 1;
        }
    }
    return end;
}

}  // namespace

std::string_view head_comments(std::string_view text) {
    const char* const end = text.data() + text.size();
    const char* p = skip_space(text.data(), end);
    while (p != end && *p == '#') {
        p = skip_space(skip_line(p, end), end);
    }
    return text.substr(0, static_cast<std::size_t>(p - text.data()));
}

std::vector<TextPiece> cut_at_lines(std::string_view text) {
    const char* const end = text.data() + text.size();
    return cut_text(text, text_piece_bytes, [end](const char*, const char* from) { return next_cut(from, end); });
}

std::string first_line_words(const LeftOut& left_out, std::string_view text) {
    return ", the first in line " + std::to_string(line_of(text, static_cast<std::size_t>(left_out.first - text.data())));
}

std::string first_word_words(const LeftOut& left_out, std::string_view text) {
    return first_line_words(left_out, text) + ": " + word_at(left_out.first, text.data() + text.size());
}

/// Counts eight characters at a time; nothing if the line holds a comment, a backslash, a tab or the end of the text.
std::optional<std::size_t> LineParser::count_plain_words() {
    std::size_t words = 0;
    std::uint64_t before = 0;  // whether the last character was part of a word
    for (const char* p = p_; end_ - p >= 8; p += 8) {
        const std::uint64_t eight = load_eight(p);
        const std::uint64_t low_bits = eight & ~eight_of('\x80');
        const std::uint64_t control = ~((low_bits + eight_of('\x60')) | eight) & eight_of('\x80');
        const std::uint64_t stops = control | bits_where(eight, '#') | bits_where(eight, '\\');
        const int stop = std::countr_zero(stops) & ~7;
        std::uint64_t letters = ((low_bits + eight_of('\x5F')) | eight) & eight_of('\x80');
        letters &= stops != 0 ? (std::uint64_t{1} << stop) - 1 : ~std::uint64_t{0};
        const std::uint64_t begins = letters & ~(letters << 8 | before);
        words += begins / 0x80 * eight_of(1) >> 56;
        before = letters >> 56;
        if (stops != 0) {
            p += stop / 8;
            p_ = ends_line(*p) ? p : p_;
            return ends_line(*p) ? std::optional(words) : std::nullopt;
        }
    }
    return std::nullopt;
}

std::size_t LineParser::count_words() {
    if (const std::optional<std::size_t> plain = count_plain_words()) {
        return *plain;
    }
    std::size_t words = 0;
    for (; to_word(); skip_word()) {
        ++words;
    }
    return words;
}

void LineParser::skip_rest() {
    if (p_ != end_ && ends_line(*p_)) {
        return;
    }
    const char* const line_end = skip_line(p_, end_);
    if (continued_ && line_end != p_ && line_end[-1] == '\\') {
        count_words();  // stops at a comment, where the backslash joins nothing
        p_ = skip_line(p_, end_);
    } else {
        p_ = line_end;
    }
}

void LineParser::vertex(double* xyz, int others) {
    for (int axis = 0; axis < 3; ++axis) {
        xyz[axis] = coordinate();
    }
    other_numbers(others);
}

double LineParser::coordinate() {
    if (!to_word()) {
        fail("expected a coordinate (a vertex has three), found " + found());
    }
    double value = 0;
    if (const NumberText got = number(value); got != NumberText::read) {
        fail(coordinate_problem(got, "double", found()));
    }
    return value;
}

int LineParser::other_numbers(int most) {
    int count = 0;
    for (; to_word(); ++count) {
        double ignored = 0;
        if (count == most) {
            fail("expected the end of the line, found " + found());
        }
        if (number(ignored) == NumberText::malformed) {
            fail("expected a number or the end of the line, found " + found());
        }
        skip_word();  // where the number is not finite
    }
    return count;
}

NumberText LineParser::number(double& value) {
    const NumberText got = read_number(p_, end_, value);
    if (got != NumberText::malformed || !continued_) {
        return got;
    }
    // It may end at a backslash that continues the line.
    const char* word_end = p_;
    while (!word_ends(word_end)) {
        ++word_end;
    }
    return read_number(p_, word_end, value);
}

std::string LineParser::found() const {
    if (p_ != end_ && ends_line(*p_)) {
        return "the end of the line";
    }
    const char* const word_end = lamella::skip_word(p_, end_);
    const bool joined = continued_ && word_end != p_ && continuation_at(word_end - 1, end_) != 0;
    return word_at(p_, end_) + (joined ? ": put a blank before the backslash if the number ends there" : "");
}

}  // namespace lamella
