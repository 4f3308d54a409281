// lamella convert of a mesh: any file that can be read, as one that can be sliced within a budget of memory.
#pragma once

#include <string>
#include <vector>

#include "files/mesh_input.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli {

/// Writes the mesh of `inputs`, which must be one, to `output`: binary STL or PLY. Warns of coordinates that STL rounds, and
/// of a unit that is lost. Throws Failure.
void convert_mesh(const std::vector<std::string>& inputs, const std::string& output, const MeshArguments& reading,
                  Interrupt& interrupt);

}  // namespace lamella::cli
