// Text whose statements are lines, as in OBJ and OFF.
#pragma once

#include "io/text/text.hpp"

namespace lamella {

/// White space within a line.
constexpr bool is_blank(char c) {
    return (c == ' ') | (c == '\t') | (c == '\v') | (c == '\f');
}

/// The bytes of a backslash and the line end after it, which join two lines; 0 where there is none at `p`.
inline std::size_t continuation_at(const char* p, const char* end) {
    if (p == end || *p != '\\' || p + 1 == end || !ends_line(p[1])) {
        return 0;
    }
    return p + 2 != end && p[1] == '\r' && p[2] == '\n' ? 3 : 2;
}

inline const char* skip_blank(const char* p, const char* end) {
    while (p != end && is_blank(*p)) {
        ++p;
    }
    return p;
}

/// The comments and empty lines that `text` begins with.
std::string_view head_comments(std::string_view text);

/// Pieces of about 1 MB. Each one ends after a line end that no backslash precedes, or with the text.
std::vector<TextPiece> cut_at_lines(std::string_view text);

/// Items that a reader leaves out of a piece or of the whole text.
struct LeftOut {
    std::size_t count = 0;
    const char* first = nullptr;

    void add(const char* at) { add({1, at}); }
    /// Precondition: what `next` counts comes after what was counted.
    void add(const LeftOut& next) {
        first = first != nullptr ? first : next.first;
        count += next.count;
    }
};

/// ", the first in line 7": where in the whole text it is. Precondition: left_out.count > 0.
std::string first_line_words(const LeftOut& left_out, std::string_view text);
/// ", the first in line 7: 'abc'", with the word that is there.
std::string first_word_words(const LeftOut& left_out, std::string_view text);

/// Reads words and numbers line by line.
class LineParser {
public:
    /// Precondition: `end` is right after a line end, or the end of the text.
    LineParser(const char* begin, const char* end, bool continued) : p_(begin), end_(end), continued_(continued) {}

protected:
    /// To the next word of the line, over line ends that a backslash precedes. False: there is none.
    bool to_word() {
        p_ = skip_blank(p_, end_);
        while (continued_ && p_ != end_ && *p_ == '\\' && continuation_at(p_, end_) != 0) {
            p_ = skip_blank(p_ + continuation_at(p_, end_), end_);
        }
        return p_ != end_ && !ends_line(*p_) && *p_ != '#';
    }

    /// True if a word may end at `p`. It ends at no backslash that a character follows in the next line: there some readers
    /// go on with the word, and others begin one.
    bool word_ends(const char* p) const {
        if (p == end_ || is_space(*p)) {
            return true;
        }
        const std::size_t joint = continued_ ? continuation_at(p, end_) : 0;
        return joint != 0 && (p + joint == end_ || is_space(p[joint]));
    }

    /// To the end of the word at p_.
    void skip_word() {
        const char* p = p_;
        do {
            while (p != end_ && !is_space(*p) && *p != '\\') {
                ++p;
            }
        } while (!word_ends(p) && ++p);
        p_ = p;
    }

    /// Skips the rest of the line's words and counts them. Precondition: p_ is not within a word.
    std::size_t count_words();

    /// To the end of the line, the lines that continue it included. Comments are not continued.
    void skip_rest();

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

private:
    std::optional<std::size_t> count_plain_words();
    NumberText number(double& value);

    bool continued_;  // by a backslash
};

}  // namespace lamella
