// Numbers as the values of attributes.
#pragma once

#include <charconv>
#include <cstdint>
#include <string_view>
#include <system_error>

#include "io/text/text.hpp"

namespace lamella::three_mf {

/// The number that `text` is, with white space around it or none.
inline NumberText number_in(std::string_view text, double& value) {
    const char* const end = text.data() + text.size();
    const char* p = skip_space(text.data(), end);
    if (p == end) {
        return NumberText::malformed;
    }
    const NumberText answer = read_number(p, end, value);
    return answer != NumberText::read || skip_space(p, end) == end ? answer : NumberText::malformed;
}

inline bool integer_in(std::string_view text, std::uint32_t& value) {
    const char* const end = text.data() + text.size();
    const std::from_chars_result got = std::from_chars(skip_space(text.data(), end), end, value);
    return got.ec == std::errc() && skip_space(got.ptr, end) == end;
}

}  // namespace lamella::three_mf
