// Files that people take for meshes, named for what they are.
#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// What a file that begins so is, where it can be no mesh: "is text in UTF-16; ...". Else empty.
std::string foreign_content(std::string_view sample);

}  // namespace lamella
