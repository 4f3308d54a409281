// Turns shells by their nesting in space: check()'s first stages, and rays that tell what lies wholly within what.
#include "lamella/weld.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "lamella/check.hpp"
#include "mesh/check/finders.hpp"

namespace lamella {

namespace {

Result<OrientedMesh> orient_or_throw(const MeshView& view, const Frame& frame, const Context& context) {
    Context own = context;
    own.memory = nullptr;  // the host's is for the mesh
    const Parallel parallel(own);
    OrientedMesh oriented{.mesh = require(weld(view, 0, parallel.within(context)))};
    MeshCheck found;
    measure_mesh(oriented.view(), frame, parallel, 0.3, found);
    parallel.begin_stage(0.5, 14);
    const GridMesh grid = make_grid_mesh(oriented.view(), frame, found, parallel);
    if (!grid.faces.empty()) {
        parallel.begin_stage(0.6, 8);
        const EdgeTable edges(grid, parallel);
        parallel.begin_stage(0.7, 7);
        const EmbeddedStars stars(grid, edges, parallel);
        parallel.begin_stage(0.8, 9);
        const FaceTree tree = make_face_tree(grid, stars, parallel);
        parallel.begin_stage(0.99, 16);
        const FaultCollector faults(grid, 0, found.findings);
        const Array<std::uint32_t> shell_of = find_shells(grid, edges, tree, faults, found, parallel, true);
        for (std::size_t face = 0; face < grid.faces.size(); ++face) {
            if (is_misoriented(found.shells[shell_of[face]])) {
                const std::size_t first = 3 * std::size_t{grid.faces[face].source};
                std::swap(oriented.mesh.indices[first + 1], oriented.mesh.indices[first + 2]);
            }
        }
    }
    oriented.shells = found.shells.size();
    oriented.turned_shells =
        static_cast<std::uint64_t>(std::count_if(found.shells.begin(), found.shells.end(), is_misoriented));
    const bool all_closed =
        std::all_of(found.shells.begin(), found.shells.end(), [](const MeshShell& shell) { return shell.closed; });
    oriented.complete = found.nesting_complete && (oriented.turned_shells == 0 || all_closed);
    parallel.finish();
    return oriented;
}

}  // namespace

Result<OrientedMesh> orient_shells(const MeshView& mesh, double grid_mm, const Context& context) noexcept {
    return guarded(context, [&] { return orient_or_throw(mesh, {.grid_mm = grid_mm}, context); });
}

}  // namespace lamella
