// Numbers in messages: "1 triangle", "2 triangles", "0.032".
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace lamella {

/// `count` with the noun in its number; `plural` where an s does not make it.
inline std::string counted(std::uint64_t count, std::string_view noun, std::string_view plural = {}) {
    const bool irregular = count != 1 && !plural.empty();
    return std::to_string(count) + " " + std::string(irregular ? plural : noun) + (count == 1 || irregular ? "" : "s");
}

/// exact_text() where the C++ library has no std::to_chars() for doubles, as that of emscripten 3.1. Its C library has no
/// locales.
inline std::string exact_text_by_trial(double value) {
    const auto printed = [value](const char* format, int decimals) {
        std::array<char, 400> text{};  // The longest has 327 characters.
        return std::string(text.data(),
                           static_cast<std::size_t>(std::snprintf(text.data(), text.size(), format, decimals, value)));
    };
    const auto reads_back = [value](const std::string& text) { return std::strtod(text.c_str(), nullptr) == value; };
    if (!std::isfinite(value)) {
        return printed("%.*f", 0);
    }
    int decimals = 0;
    std::string scientific = printed("%.*e", decimals);
    while (!reads_back(scientific)) {
        // More numbers are read as a power of two from above than from below, and no such power has a fixed form as short.
        std::string above = scientific;
        const std::size_t at = above.find_last_of("012345678", above.find('e'));
        std::replace(above.begin() + static_cast<std::ptrdiff_t>(at + 1),
                     above.begin() + static_cast<std::ptrdiff_t>(above.find('e')), '9', '0');
        if (at != std::string::npos && (++above[at], reads_back(above))) {
            return above;
        }
        scientific = printed("%.*e", ++decimals);
    }
    const int exponent = std::atoi(scientific.c_str() + scientific.find('e') + 1);
    std::string fixed = printed("%.*f", std::max(decimals - exponent, 0));
    return fixed.size() <= scientific.size() ? fixed : scientific;
}

/// Shortest decimal text that reads back as the same number.
inline std::string exact_text(double value) {
    const auto text_of = [](auto number) -> std::string {
        std::array<char, 32> text{};  // The longest has 24 characters.
        if constexpr (requires { std::to_chars(text.data(), text.data() + text.size(), number); }) {
            return {text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr};
        } else {
            return exact_text_by_trial(number);
        }
    };
    return text_of(value);
}

}  // namespace lamella
