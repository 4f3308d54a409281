// What a diagnosis found, for people.
#pragma once

#include <cstddef>
#include <string>

#include "lamella/io/mesh_file.hpp"
#include "lamella/mesh/check.hpp"

namespace lamella::cli {

struct CheckWords {
    std::size_t most_places;  ///< of each kind
    bool all_kinds;           ///< also those that were not found
};

/// One line a kind with its count, below it its places; then what was examined; the last line is the verdict.
std::string check_words(const std::string& path, const MeshFile& mesh, const MeshCheck& check, const CheckWords& how);

}  // namespace lamella::cli
