// The XML of a VTP file: which pieces it has, and where their arrays are.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "io/read/vtk/vtk_file.hpp"
#include "io/read/vtk/vtp_data.hpp"
#include "io/xml/xml.hpp"

namespace lamella {

/// Polygons or strips.
struct VtpCells {
    std::uint64_t count = 0;
    std::optional<VtpArray> connectivity;
    std::optional<VtpArray> offsets;
};

struct VtpPiece {
    const char* element = nullptr;  ///< where in the file it begins
    std::uint64_t point_count = 0;
    std::optional<VtpArray> points;
    VtpCells polygons;
    VtpCells strips;
};

struct VtpDocument {
    VtpForm form;
    std::deque<VtpPiece> pieces;
    std::optional<XmlUnboundName> unbound_name;
    std::optional<VtpArray> space;  ///< the string of that name among the field data, as 3D Slicer writes it
};

/// Reads the document up to the appended data, which are no XML. Throws errors.
VtpDocument read_vtp_document(VtkFile& file);

}  // namespace lamella
