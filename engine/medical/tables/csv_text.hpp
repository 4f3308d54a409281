// Text in a CSV file.
#pragma once

#include <string>

#include "lamella/io/name_text.hpp"

namespace lamella {

/// In UTF-8, and quoted where it has to be.
inline std::string csv_text(const std::string& bytes) {
    std::string text = utf8_text(bytes);
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string all = "\"";
    for (const char c : text) {
        all += c == '"' ? "\"\"" : std::string(1, c);
    }
    return all + "\"";
}

}  // namespace lamella
