// What every report says of the mesh file, and what the program adds.
#pragma once

#include "io/write/json.hpp"
#include "lamella/io/report.hpp"

namespace lamella {

/// The program's members that belong in `place`.
void write_members(JsonText& json, const ReportParts& parts, ReportPlace place);

/// "mesh", then "file" if there is one.
void write_mesh(JsonText& json, const ReportParts& parts);

/// The member "box_mm".
void write_box(JsonText& json, const double (&min_mm)[3], const double (&max_mm)[3]);

}  // namespace lamella
