// ASCII PLY as nearly everyone writes it, one row a line, parsed in parallel.
#pragma once

#include "io/read/ply/ply_body.hpp"

namespace lamella {

/// False: rows are no lines, or something is wrong, which a reader that goes from number to number will find. Whether it
/// succeeds, and what it makes, does not depend on threads.
bool read_ply_lines(const PlyInput& input, PlyMesh& mesh);

/// The same of rows that are lines with more words than the header declares, which are ignored and counted.
bool read_ply_long_lines(const PlyInput& input, PlyMesh& mesh);

}  // namespace lamella
