// Small text files as people's programs write them: manifests, heights, matrices.
#pragma once

#include <string>

namespace lamella::cli {

/// All of the file, but for a byte-order mark. Throws Failure (bad_input) of one that cannot be read, is larger than 1 GiB
/// or is in UTF-16.
std::string read_text(const std::string& path);

}  // namespace lamella::cli
