#include "9_write/json.hpp"

#include <algorithm>
#include <cmath>

#include "9_write/describe.hpp"

namespace lamella {

namespace {

/// Bytes of the UTF-8 character that `text` begins with, or 0 if it begins with none (RFC 3629).
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const unsigned lead = byte(0);
    if (lead < 0x80) {
        return 1;
    }
    const std::size_t length = lead >= 0xf0 ? 4 : (lead >= 0xe0 ? 3 : 2);
    unsigned code = lead & (0xffU >> (length + 1));
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xc0U) != 0x80) {
            return 0;
        }
        code = code << 6 | (byte(i) & 0x3fU);
    }
    constexpr unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    return lead >= 0xc0 && lead < 0xf8 && code >= least[length] && code <= 0x10ffff && !surrogate ? length : 0;
}

}  // namespace

void JsonText::value(double number) {
    if (!std::isfinite(number)) {
        put("null");
        return;
    }
    std::string digits = exact_text(number);
    if (digits.find_first_of(".e") == std::string::npos) {
        digits += ".0";
    }
    put(digits);
}

void JsonText::value(std::string_view text) {
    put("\"");
    quote(text);
    text_ += '"';
}

void JsonText::key(std::string_view name) {
    value(name);
    text_ += ": ";
    after_key_ = true;
}

/// A value, or how it begins: behind its key, or on a line of its own.
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

void JsonText::quote(std::string_view text) {
    constexpr std::string_view hex = "0123456789abcdef";
    while (!text.empty()) {
        const std::size_t length = character_length(text);
        const char first = text[0];
        if (length == 0) {
            text_ += "\xEF\xBF\xBD";
        } else if (first == '"' || first == '\\') {
            (text_ += '\\') += first;
        } else if (static_cast<unsigned char>(first) < 0x20) {
            ((text_ += "\\u00") += hex[static_cast<unsigned char>(first) >> 4]) += hex[first & 15];
        } else {
            text_ += text.substr(0, length);
        }
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
}

}  // namespace lamella
