// The stages of check(), each of which finds some kinds of faults.
#pragma once

#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/mesh/check.hpp"
#include "mesh/check/edge_table.hpp"
#include "mesh/check/notes.hpp"

namespace lamella {

/// Edges by the faces at each. O(edges).
void find_edge_faults(const GridMesh& mesh, const EdgeTable& edges, Notes& notes);

/// Loops of boundary edges. O(b log b).
void find_loops(const GridMesh& mesh, const EdgeTable& edges, Notes& notes);

/// Vertices whose triangles do not form one cone. O(n).
void find_split_vertices(const GridMesh& mesh, const EdgeTable& edges, Notes& notes);

/// Flipped faces and one-sided patches. O(n).
void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, Notes& notes);

/// Faces that are bad by themselves, and faces on the same three vertices. O(n).
void find_face_faults(const GridMesh& mesh, double sliver_ratio, Notes& notes);

/// Shells, their orientations and nesting. Returns the shell of each face.
std::vector<std::uint32_t> find_shells(const GridMesh& mesh, const EdgeTable& edges, const Notes& notes, MeshCheck& check,
                                       const Parallel& parallel);

/// Pairs of faces that cross, overlap or touch. Returns for each shell 1 if it and another one are closed and meet, else 0.
std::vector<std::uint8_t> find_meeting_faces(const GridMesh& mesh, const std::vector<std::uint32_t>& shell_of,
                                             const std::vector<MeshShell>& shells, Notes& notes, const Parallel& parallel);

/// Shells whose orientation contradicts their depth, where the depth is conclusive (shells.cpp).
void find_misoriented_shells(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other,
                             bool all_known, Notes& notes);

/// T-junctions and cracks.
void find_gaps(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, Notes& notes, const Parallel& parallel);

}  // namespace lamella
