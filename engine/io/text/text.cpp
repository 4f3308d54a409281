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
        return static_cast<int>(before == '\n') | (static_cast<int>(before == '\r') & static_cast<int>(c != '\n'));
    });
    const bool at_end = offset > 0 && offset == text.size() && ends_line(text.back());
    return 1 + ends + (at_end ? 1 : 0);
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

std::size_t close_gaps(std::span<const ItemRun> runs, std::size_t item_bytes, std::byte* items) {
    std::size_t all = 0;
    for (const ItemRun& run : runs) {
        if (run.count > 0 && run.first != all) {
            std::memmove(items + all * item_bytes, items + run.first * item_bytes, run.count * item_bytes);
        }
        all += run.count;
    }
    return all;
}

}  // namespace lamella
