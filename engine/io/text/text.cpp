#include "io/text/text.hpp"

#include "io/read/input_file.hpp"

namespace lamella {

std::string lower_case(std::string_view text) {
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return lower_case(c); });
    return lower;
}

bool begins_in_any_case(std::string_view text, std::string_view start) {
    return text.size() >= start.size() &&
           std::equal(start.begin(), start.end(), text.begin(), [](char wanted, char c) { return lower_case(c) == wanted; });
}

std::string without_escapes(std::string_view text) {
    std::string plain;
    for (std::size_t at = 0; at < text.size(); ++at) {
        unsigned char byte = 0;
        const char* const end = text.data() + std::min(at + 3, text.size());
        const bool escaped =
            text[at] == '%' && std::from_chars(text.data() + at + 1, end, byte, 16).ptr == text.data() + at + 3;
        plain += escaped ? static_cast<char>(byte) : text[at];
        at += escaped ? 2 : 0;
    }
    return plain;
}

std::optional<std::string> path_within(std::string_view path) {
    path.remove_prefix(path.starts_with('/') ? 1 : 0);
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('/', begin), path.size());
        const std::string_view segment = path.substr(begin, end - begin);
        if (segment.empty() || segment == "." || segment == ".." || segment.find_first_of("\\:") != std::string_view::npos) {
            return std::nullopt;
        }
        begin = end + 1;
    }
    return std::string(path);
}

std::string word_at(const char* p, const char* end) {
    if (p == end) {
        return "the end of the file";
    }
    constexpr std::ptrdiff_t longest = 32;
    const char* shown_end = skip_word(p, p + std::min(longest, end - p));
    std::string quoted("'");
    quoted += printable({p, static_cast<std::size_t>(shown_end - p)});
    quoted += shown_end == end || is_space(*shown_end) ? "'" : "...'";
    return quoted;
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t longest = 64;
    return "'" + printable(text.substr(0, longest)) + (text.size() > longest ? "...'" : "'");
}

std::string coordinate_problem(NumberText got, const std::string& type, const std::string& found) {
    return got == NumberText::malformed ? "malformed coordinate " + found
                                        : "coordinate is not a finite " + type + ": " + found;
}

std::size_t line_of(std::string_view text, std::size_t offset) {
    const std::size_t ends = count_in(text.substr(0, offset + 1), [](char before, char c) {
        return static_cast<int>(before == '\n') | (static_cast<int>(before == '\r') & static_cast<int>(c != '\n')) |
               static_cast<int>(before == joined_line_end);
    });
    const bool at_end = offset > 0 && offset == text.size() && ends_line(text.back());
    return 1 + ends + (at_end ? 1 : 0);
}

std::optional<double> parse_number(std::string_view text) noexcept {
    double value = 0;
    const char* at = text.data();
    const char* const end = at + text.size();
    const bool is_number = !text.empty() && !is_space(*at) && read_number(at, end, value) == NumberText::read && at == end;
    return is_number ? std::optional(value) : std::nullopt;
}

std::optional<std::vector<double>> parse_numbers(std::string_view text, char separator) {
    std::vector<double> numbers;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(separator, begin), text.size());
        const std::optional<double> number = parse_number(trimmed(text.substr(begin, end - begin)));
        if (!number) {
            return std::nullopt;
        }
        numbers.push_back(*number);
        begin = end + 1;
    }
    return numbers;
}

std::string_view trimmed(std::string_view text, std::string_view padding) {
    const std::size_t begin = text.find_first_not_of(padding);
    return begin == std::string_view::npos ? std::string_view()
                                           : text.substr(begin, text.find_last_not_of(padding) - begin + 1);
}

// --- pieces

std::vector<TextPiece> cut_text(std::string_view text, std::size_t piece_bytes,
                                FunctionRef<const char*(const char* begin, const char* from)> end_of_piece) {
    std::vector<TextPiece> pieces;
    const char* const end = text.data() + text.size();
    for (const char* begin = text.data(); begin != end;) {
        const auto left = static_cast<std::size_t>(end - begin);
        const char* const cut = left > piece_bytes ? end_of_piece(begin, begin + piece_bytes) : end;
        pieces.push_back({.text = {begin, static_cast<std::size_t>(cut - begin)}});
        begin = cut;
    }
    return pieces;
}

std::size_t number_items(std::span<TextPiece> pieces) {
    std::size_t all = 0;
    for (TextPiece& piece : pieces) {
        piece.first = std::exchange(all, all + piece.count);
    }
    return all;
}

std::size_t count_words(std::string_view text) {
    const bool begins = !text.empty() && !is_space(text[0]);
    return (begins ? 1 : 0) + count_in(text, [](char before, char c) {
               return static_cast<int>(is_space(before)) & static_cast<int>(!is_space(c));
           });
}

// --- Text whose statements are lines

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
    return cut_text(text, text_piece_bytes, [end](const char*, const char* from) {
        const char* const line_end = skip_line(from, end);
        const bool two = end - line_end > 1 && line_end[0] == '\r' && line_end[1] == '\n';
        return line_end + (two ? 2 : line_end != end ? 1 : 0);
    });
}

std::string first_line_words(const LeftOut& left_out, std::string_view text) {
    return ", the first in line " + std::to_string(line_of(text, static_cast<std::size_t>(left_out.first - text.data())));
}

std::string first_word_words(const LeftOut& left_out, std::string_view text) {
    return first_line_words(left_out, text) + ": " + word_at(left_out.first, text.data() + text.size());
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
    if (const NumberText got = read_number(p_, end_, value); got != NumberText::read) {
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
        if (read_number(p_, end_, ignored) == NumberText::malformed) {
            fail("expected a number or the end of the line, found " + found());
        }
        p_ = skip_word(p_, end_);  // where the number is not finite
    }
    return count;
}

std::string LineParser::found() const {
    if (p_ != end_ && ends_line(*p_)) {
        return "the end of the line";
    }
    const char* const word_end = skip_word(p_, end_);
    const bool joined = word_end != p_ && word_end[-1] == '\\' && word_end != end_ && ends_line(*word_end);
    return word_at(p_, end_) + (joined ? ": put a blank before the backslash if the number ends there" : "");
}

}  // namespace lamella
