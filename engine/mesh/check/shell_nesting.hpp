// Which shell lies within which.
#pragma once

#include <cstdint>
#include <vector>

#include "lamella/mesh/check.hpp"
#include "mesh/check/face_tree.hpp"

namespace lamella {

/// Fills in depth and parent. Rays upwards from a few vertices of each shell count, exactly, how often each closed shell
/// winds around them; where a vertex lies on the other shell's surface, the next one is tried. Of `whole`, a shell is
/// around only if no face of the other crosses it and none of these vertices lies outside. Returns false where
/// the work would have exceeded search_budget().
bool nest_shells(const GridMesh& mesh, const FaceTree& tree, const Array<std::uint32_t>& shell_of,
                 std::vector<MeshShell>& shells, bool whole, const Parallel& parallel);

}  // namespace lamella
