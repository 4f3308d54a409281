// Names of outputs with places for what each mesh is called: 'out/{parent}/{stem}.nii.gz'.
#pragma once

#include <string>

#include "batch/sources/mesh_sources.hpp"

namespace lamella::cli::batch {

/// Of the mesh a/b/liver.stl.gz, found below the SOURCE a: {stem} is liver, {name} liver.stl.gz, {parent} b, {dir} b, the
/// folder below SOURCE. `option` names the pattern in messages. Throws Failure (bad_usage) of another word in braces.
std::string expand_pattern(const std::string& pattern, const MeshSource& mesh, const std::string& option);

/// The folder in which all that the pattern names lies: "out" of 'out/{stem}.svg', "." of '{stem}.svg'.
std::string fixed_folder(const std::string& pattern);

}  // namespace lamella::cli::batch
