#include "io/read/obj_off/off_numbers.hpp"

#include <algorithm>

namespace lamella {

std::string_view off_header_word(std::string_view text) {
    const char* const begin = text.data() + head_comments(text).size();
    const char* const end = text.data() + text.size();
    const std::string_view word(begin, static_cast<std::size_t>(skip_word(begin, end) - begin));
    const bool is_header = word.ends_with("OFF") && word.size() <= std::string_view("STCN4nOFF").size() &&
                           word.find_first_not_of("STCN4nOF") == std::string_view::npos;
    return is_header ? word : std::string_view();
}

bool OffNumbers::next_word() {
    for (p_ = skip_space(p_, end_); !to_word(); p_ = skip_space(skip_line(p_, end_), end_)) {
        if (p_ == end_) {
            return false;
        }
    }
    return true;
}

bool OffNumbers::whole_number(std::size_t& number, const char* what) {
    constexpr std::size_t limit = std::size_t{1} << 53;
    if (!to_word()) {
        return fail(std::string("expected ") + what + ", found " + found());
    }
    const char* const begin = p_;
    p_ = read_digits(begin, end_, number);
    number = std::min(number, limit);
    if (p_ == begin || !word_ends(p_)) {
        p_ = begin;
        return fail(std::string("expected ") + what + ", found " + found());
    }
    return true;
}

bool OffNumbers::vertex_number(std::size_t vertex_count, std::uint32_t& vertex) {
    std::size_t number = 0;
    to_word();
    const char* const begin = p_;
    if (!whole_number(number, "a vertex number")) {
        return false;
    }
    if (number >= vertex_count) {
        p_ = begin;
        return fail("vertex number out of range: the file has " + counted(vertex_count, "vertex", "vertices") + ", found " +
                    found());
    }
    vertex = static_cast<std::uint32_t>(number);
    return true;
}

bool OffNumbers::header(OffCounts& counts) {
    const std::string_view word = off_header_word({p_, static_cast<std::size_t>(end_ - p_)});
    p_ = word.empty() ? p_ : word.data();
    if (word.find_first_of("4n") != std::string_view::npos) {
        return fail("vertices of other than three coordinates are not read: " + found());
    }
    p_ += word.size();
    next_word();
    counts.at = p_;
    if (!whole_number(counts.vertices, "the number of vertices")) {
        return false;
    }
    next_word();
    std::size_t edges = 0;
    return whole_number(counts.faces, "the number of faces") && (!to_word() || whole_number(edges, "the number of edges")) &&
           other_numbers(0);
}

}  // namespace lamella
