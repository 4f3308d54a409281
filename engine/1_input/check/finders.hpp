// The parts of the diagnosis, each finding faults of some kinds.
#pragma once

#include "1_input/check/edge_table.hpp"
#include "1_input/check/notes.hpp"
#include "base/parallel.hpp"
#include "lamella/check.hpp"

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

/// Shells, their senses and nesting, and what of it does not fit.
void find_shells(const GridMesh& mesh, const EdgeTable& edges, Notes& notes, MeshCheck& check, const Parallel& parallel);

/// Pairs of faces that cross, overlap or touch.
void find_meeting_faces(const GridMesh& mesh, Notes& notes, const Parallel& parallel);

/// T-junctions and cracks.
void find_gaps(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, Notes& notes, const Parallel& parallel);

}  // namespace lamella
