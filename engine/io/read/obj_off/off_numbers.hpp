// The head and the numbers of OFF, for its two readers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/words.hpp"
#include "io/text/lines.hpp"

namespace lamella {

/// The header's word, or nothing.
std::string_view off_header_word(std::string_view text);

struct OffCounts {
    std::size_t vertices = 0;
    std::size_t faces = 0;
    const char* at = nullptr;

    std::size_t lines() const { return vertices + faces; }
    std::string words() const { return counted(vertices, "vertex", "vertices") + " and " + counted(faces, "face"); }
    /// Whether `bytes` can hold as many numbers. The shortest are "0 0 0" of a vertex and "0" of a face without corners,
    /// each number with a space after it; the last may lack it.
    bool fit(std::size_t bytes) const { return 6 * vertices + 2 * faces <= bytes + 1; }
};

class OffNumbers : protected LineParser {
public:
    explicit OffNumbers(std::string_view text) : LineParser(text.data(), text.data() + text.size(), false) {}

    /// Reads the file's head, which rest() then follows. The number of edges may be absent: it is on the line of the faces'.
    bool header(OffCounts& counts);
    const char* rest() const { return p_; }

    using LineParser::failure;

protected:
    /// To the next word, over line ends and comments. False: there is none.
    bool next_word();
    /// The next word of the line.
    bool whole_number(std::size_t& number, const char* what);
    bool vertex_number(std::size_t vertex_count, std::uint32_t& vertex);
};

}  // namespace lamella
