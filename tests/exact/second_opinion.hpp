// CGAL's own slicer, which asks a tree of boxes for the edges and walks the mesh's half-edges, beside the exact contours.
#pragma once

#include <span>
#include <string>

#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace exact {

/// The first plane of `result` at which CGAL::Polygon_mesh_slicer finds other exact contours than chains_at(), in words; or
/// empty. The triangles must form a closed manifold.
std::string second_opinion(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles);

}  // namespace exact
