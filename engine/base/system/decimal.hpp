// Doubles in decimal.
#pragma once

#include <charconv>
#include <cstddef>

namespace lamella {

inline constexpr std::size_t longest_decimal = 24;

/// Writes the shortest text that reads back as the same number, without an exponent where that is no longer. Returns the
/// text's length, at most longest_decimal.
#ifdef __EMSCRIPTEN__  // whose C++ library has no std::to_chars() for doubles
std::size_t write_decimal(double value, char* text) noexcept;
#else
inline std::size_t write_decimal(double value, char* text) noexcept {
    return static_cast<std::size_t>(std::to_chars(text, text + longest_decimal, value).ptr - text);
}
#endif

}  // namespace lamella
