// Counts the edges of a mesh by the faces that meet there (paper 1.3: closed meshes).
#pragma once

#include <cstdint>

#include "base/parallel.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

struct EdgeCensus {
    std::uint64_t degenerate = 0;  ///< triangles with two equal vertices; their edges are left out
    std::uint64_t edges = 0;
    std::uint64_t boundary = 0;
    std::uint64_t overfull = 0;
    std::uint64_t mismatched = 0;
    std::uint64_t unbalanced = 0;  ///< edges with more faces one way than the other
    std::uint64_t shells = 0;
    std::uint64_t joined = 0;          ///< edges of the grid that stand for several ones
    std::uint64_t exact_boundary = 0;  ///< `boundary` where vertices are one only if their coordinates are equal as numbers
};

/// Four calls of run(), or eight where the grid joins vertices or lets triangles collapse. O(n) expected; 16 bytes a
/// triangle (32 from 2^32 / 3 triangles on) beside the mesh. The counts do not depend on threads. Precondition: indices in
/// range, coordinates within the grid. Throws std::bad_alloc.
EdgeCensus count_edges(const MeshView& mesh, const Transform& transform, double unit_mm, const Parallel& parallel);

/// EdgeCensus::exact_boundary alone. As much work as all of count_edges().
std::uint64_t count_exact_boundary(const MeshView& mesh, const Parallel& parallel);

}  // namespace lamella
