// Numbers as the types of mesh formats: words, or bytes in either order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "files.hpp"

namespace lamella::input_test {

enum class Coding : std::uint8_t { text, little_endian, big_endian };

/// `value` as the type of that name in PLY, legacy VTK or VTP: a word, or bytes. What an integer does not hold wraps round.
template <class Number>
std::string encoded(const std::string& type, Number value, Coding coding) {
    const auto has = [&](const char* part) { return type.find(part) != std::string::npos; };
    const auto written = [coding](auto number) {
        return coding == Coding::text ? std::to_string(number) + " " : bytes_of(number, coding == Coding::big_endian);
    };
    const bool is_unsigned = type[0] == 'u' || type[0] == 'U';
    if (has("loat") || has("double")) {
        return has("double") || has("64") ? written(static_cast<double>(value)) : written(static_cast<float>(value));
    }
    const auto whole = static_cast<std::int64_t>(value);
    switch (has("long") || has("64") ? 8 : has("short") || has("16") ? 2 : has("char") || has("8") ? 1 : 4) {
        case 8:
            return is_unsigned ? written(static_cast<std::uint64_t>(whole)) : written(whole);
        case 4:
            return is_unsigned ? written(static_cast<std::uint32_t>(whole)) : written(static_cast<std::int32_t>(whole));
        case 2:
            return is_unsigned ? written(static_cast<std::uint16_t>(whole)) : written(static_cast<std::int16_t>(whole));
        default:
            return is_unsigned ? written(static_cast<std::uint8_t>(whole)) : written(static_cast<std::int8_t>(whole));
    }
}

/// In text each row is a line.
template <class Row>
std::string encoded_rows(const std::string& type, const std::vector<Row>& rows, Coding coding) {
    std::string bytes;
    for (const Row& row : rows) {
        for (const auto value : row) {
            bytes += encoded(type, value, coding);
        }
        if (coding == Coding::text && !row.empty()) {
            bytes.back() = '\n';
        }
    }
    return bytes;
}

}  // namespace lamella::input_test
