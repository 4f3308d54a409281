// Compares the exact contours with CGAL's own slicer, which finds edges by a tree of boxes and walks the mesh's
// half-edges.
#pragma once

#include <span>
#include <string>

#include "lamella/result.hpp"
#include "oracle/oracle.hpp"

namespace exact {

/// The first plane of `result` at which CGAL::Polygon_mesh_slicer and chains_at() find different exact contours, in words;
/// or empty. The triangles must form a closed manifold.
std::string second_opinion(const lamella::SliceResult& result, std::span<const oracle::Triangle> triangles);

}  // namespace exact
