// Mesh files in words.
#pragma once

#include <string>

#include "lamella/mesh_file.hpp"

namespace lamella::cli {

/// "binary STL, 1.9 MB", with what else is known of the file.
std::string description(const MeshFile& mesh);

/// "STL, OBJ, ...": what can be read.
std::string mesh_formats();

}  // namespace lamella::cli
