// What a diagnosis found, for people.
#pragma once

#include <cstddef>
#include <string>

#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/check.hpp"

namespace lamella::cli {

/// One line a kind with its count, below it at most `most` places; the last line is the verdict.
std::string check_words(const std::string& path, const MeshFile& mesh, const MeshCheck& check, std::size_t most);

}  // namespace lamella::cli
