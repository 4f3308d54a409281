// Small text files as people's programs write them: manifests, heights, matrices.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace lamella::cli {

/// All of the file, but for a byte-order mark. Throws Failure (bad_input) of one that cannot be read, is larger than 1 GiB
/// or is in UTF-16.
std::string read_text(const std::string& path);

/// The pieces between separators, of which one more than of these: text that ends with one has an empty last piece.
std::vector<std::string_view> split(std::string_view text, char separator);

}  // namespace lamella::cli
