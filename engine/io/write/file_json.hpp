// What every report says of the mesh file.
#pragma once

#include "io/write/json.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

/// The member "file".
void write_file(JsonText& json, const MeshFile& file);

/// The member "box_mm".
void write_box(JsonText& json, const double (&min_mm)[3], const double (&max_mm)[3]);

}  // namespace lamella
