#include "lamella/io/name_text.hpp"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "base/utf8.hpp"

namespace lamella {

namespace {

constexpr std::size_t escape_bytes = 4;

/// The byte that an escape at `at` stands for, \x5c or \x80 to \xff; 0 where there is none.
unsigned escaped_byte(std::string_view text, std::size_t at) noexcept {
    const std::string_view escape = text.substr(at, escape_bytes);
    unsigned value = 0;
    if (escape.size() < escape_bytes || !escape.starts_with("\\x")) {
        return 0;
    }
    const auto [end, problem] = std::from_chars(escape.data() + 2, escape.data() + escape_bytes, value, 16);
    const bool whole = problem == std::errc() && end == escape.data() + escape_bytes;
    return whole && (value == '\\' || value >= 0x80) ? value : 0;
}

void add_escape(std::string& text, char byte) {
    constexpr std::string_view digits = "0123456789abcdef";
    const auto value = static_cast<unsigned char>(byte);
    text += {'\\', 'x', digits[value / 16], digits[value % 16]};
}

std::string escaped(std::string_view bytes, bool backslashes) {
    std::string text;
    text.reserve(bytes.size());
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t count = character_bytes(bytes, at);
        if (count == 0 || (backslashes && bytes[at] == '\\' && escaped_byte(bytes, at) != 0)) {
            add_escape(text, bytes[at++]);
        } else {
            text += bytes.substr(at, count);
            at += count;
        }
    }
    return text;
}

}  // namespace

std::string text_of_name(std::string_view name) {
    return escaped(name, true);
}

std::string name_of_text(std::string_view text) {
    std::string name;
    name.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        const unsigned byte = escaped_byte(text, at);
        name += byte != 0 ? static_cast<char>(byte) : text[at];
        at += byte != 0 ? escape_bytes : 1;
    }
    return name;
}

std::string utf8_text(std::string_view text) {
    return escaped(text, false);
}

std::string printable(std::string_view text) {
    std::string line = utf8_text(text);
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' ' || c == '\x7f'; }, '?');
    return line;
}

}  // namespace lamella
