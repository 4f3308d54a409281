// File names as text. A name is bytes, of any kind; text is UTF-8.
//
//     const std::string text = lamella::text_of_name("l\xe4rm.stl");  // a name in Latin-1
//     std::printf("%s, %zu bytes\n", text.c_str(), lamella::name_of_text(text).size());  // l\xe4rm.stl, 8 bytes
#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// Text from which name_of_text() gives the same bytes. A byte that is no part of UTF-8 becomes `\xe4`, by its value; a
/// backslash before what looks like such an escape becomes `\x5c`. All else stays, and so does nearly every name. O(bytes).
std::string text_of_name(std::string_view name);
std::string name_of_text(std::string_view text);

/// For people: bytes that are no part of UTF-8 as above, and all else as it is. The same again changes nothing. O(bytes).
std::string utf8_text(std::string_view text);

/// The same on one line: control characters become '?'.
std::string printable(std::string_view text);

}  // namespace lamella
