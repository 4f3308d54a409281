// The files that the readers' golden cases read: one mesh of triangles, quads and larger polygons, written in every format
// with integer arithmetic alone. Large enough to be parsed by several tasks.
#pragma once

#include <map>
#include <string>

namespace golden {

/// Bytes by file name.
std::map<std::string, std::string> mesh_files();

}  // namespace golden
