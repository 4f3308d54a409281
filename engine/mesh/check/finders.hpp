// The stages of check(), each of which finds some kinds of faults.
#pragma once

#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "lamella/mesh/check.hpp"
#include "mesh/check/edge_table.hpp"
#include "mesh/check/embedded_stars.hpp"
#include "mesh/check/face_tree.hpp"
#include "mesh/check/notes.hpp"

namespace lamella {

struct EdgeCounts {
    std::uint64_t edges = 0;
    std::uint64_t unbalanced = 0;  ///< with more faces one way than the other
};

/// Edges by the faces at each. O(edges), one call of run().
EdgeCounts find_edge_faults(const GridMesh& mesh, const EdgeTable& edges, Notes& notes, const Parallel& parallel);

/// Loops of boundary edges. O(b log b) for b of them.
void find_loops(const GridMesh& mesh, const EdgeTable& edges, Notes& notes, const Parallel& parallel);

/// Vertices whose triangles do not form one cone. O(n + s log s) for s faces around vertices without embedded stars.
void find_split_vertices(const GridMesh& mesh, const EmbeddedStars& stars, Notes& notes, const Parallel& parallel);

/// Flipped faces and one-sided patches, once edge faults have been found. O(n), where any edge is mismatched.
void find_flipped_faces(const GridMesh& mesh, const EdgeTable& edges, Notes& notes, const Parallel& parallel);

/// Faces that are bad by themselves, and faces on the same three vertices. O(n), one call of run().
void find_face_faults(const GridMesh& mesh, double sliver_ratio, Notes& notes, const Parallel& parallel);

/// Shells, their orientations and nesting, `whole` as for nest_shells(). Returns the shell of each face.
Array<std::uint32_t> find_shells(const GridMesh& mesh, const EdgeTable& edges, const FaceTree& tree, const Notes& notes,
                                 MeshCheck& check, const Parallel& parallel, bool whole = false);

/// Pairs of faces that cross, overlap or touch. Returns for each shell 1 if it and another one are closed and meet, else 0.
/// The search itself leads the progress on to `progress`.
std::vector<std::uint8_t> find_meeting_faces(const GridMesh& mesh, const FaceTree& tree, const EmbeddedStars& stars,
                                             const Array<std::uint32_t>& shell_of, const std::vector<MeshShell>& shells,
                                             Notes& notes, double progress, const Parallel& parallel);

/// Shells whose orientation contradicts their depth, where the depth is conclusive (shells.cpp).
void find_misoriented_shells(const std::vector<MeshShell>& shells, const std::vector<std::uint8_t>& meets_other,
                             bool all_known, Notes& notes);

/// T-junctions and cracks.
void find_gaps(const GridMesh& mesh, const EdgeTable& edges, double tolerance_mm, Notes& notes, const Parallel& parallel);

}  // namespace lamella
