// Numbers in messages: "1 triangle", "2 triangles", "0.032".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/system/decimal.hpp"

namespace lamella {

/// `count` with the noun in its number; `plural` where an s does not make it.
inline std::string counted(std::uint64_t count, std::string_view noun, std::string_view plural = {}) {
    const bool irregular = count != 1 && !plural.empty();
    return std::to_string(count) + " " + std::string(irregular ? plural : noun) + (count == 1 || irregular ? "" : "s");
}

/// Shortest decimal text that reads back as the same number.
inline std::string exact_text(double value) {
    std::array<char, longest_decimal> text{};
    return {text.data(), write_decimal(value, text.data())};
}

/// So many hexadecimal digits.
inline std::string hex_text(std::uint64_t number, std::size_t digits = 16) {
    std::string text(digits, '0');
    for (; digits > 0; number >>= 4) {
        text[--digits] = "0123456789abcdef"[number & 15];
    }
    return text;
}

}  // namespace lamella
