#include "io/write/json.hpp"

#include <nlohmann/json.hpp>

#include "lamella/io/name_text.hpp"

namespace lamella {

void JsonText::value(double number) {
    put(nlohmann::json(number).dump());
}

void JsonText::value(std::string_view text) {
    put(nlohmann::json(utf8_text(text)).dump());
}

void JsonText::key(std::string_view name) {
    value(name);
    text_ += ": ";
    after_key_ = true;
}

/// A value or its beginning: after its key, or on a line of its own.
void JsonText::put(std::string_view word) {
    if (!after_key_ && depth_ > 0) {
        if (const char last = text_.back(); last != '{' && last != '[') {
            text_ += ',';
        }
        break_line();
    }
    after_key_ = false;
    text_ += word;
}

}  // namespace lamella
