// Turns shells by their nesting in space: check()'s first stages, and rays that tell what lies wholly within what.
#include "lamella/mesh/orient.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/guard.hpp"
#include "base/recycler.hpp"
#include "lamella/mesh/check.hpp"
#include "mesh/check/finders.hpp"
#include "mesh/measure.hpp"

namespace lamella {

namespace {

Result<OrientedMesh> orient_or_throw(const MeshView& view, const OrientOptions& options) {
    const Parallel parallel(options.control);
    Result<WeldedMesh> welded =
        weld(view, {.tolerance_mm = 0, .mm_per_unit = options.mm_per_unit, .control = parallel.within(options.control)});
    if (!welded) {
        return welded.error();
    }
    OrientedMesh oriented{.mesh = std::move(welded).value()};
    const Recycler recycler;
    const Transform to_mm = oriented.mesh.to_mm();
    MeshCheck found;
    const Result<MeshInfo> measured = measure_mesh(oriented.mesh.view(), to_mm, options.unit_mm, parallel, 0.3);
    if (!measured) {
        return measured.error();
    }
    found.info = *measured;
    parallel.begin_stage(0.5, 11);
    const GridMesh grid = make_grid_mesh(oriented.mesh.view(), to_mm, found.info, parallel, recycler.memory());
    if (!grid.faces.empty()) {
        parallel.begin_stage(0.6, 6);
        const EdgeTable edges(grid, parallel);
        parallel.begin_stage(0.7, 7);
        const EmbeddedStars stars(grid, edges, parallel);
        parallel.begin_stage(0.8, 9);
        const FaceTree tree(grid, stars, parallel);
        parallel.begin_stage(0.99, 20);
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

Result<OrientedMesh> orient_shells(const MeshView& mesh, const OrientOptions& options) noexcept {
    return guarded(options.control, [&] { return orient_or_throw(mesh, options); });
}

}  // namespace lamella
