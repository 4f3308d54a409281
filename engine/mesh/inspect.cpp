#include "lamella/mesh/inspect.hpp"

#include "base/guard.hpp"
#include "base/parallel.hpp"
#include "mesh/edge_census.hpp"
#include "mesh/measure.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

namespace {

constexpr double box_share = 0.05;  ///< of the progress, when it ends
constexpr double measure_share = 0.1;
constexpr double census_share = 0.99;

void add_census(const EdgeCensus& census, MeshInfo& info) {
    info.degenerate = census.degenerate;
    info.edges = census.edges;
    info.boundary_edges = census.boundary;
    info.exact_boundary_edges = census.exact_boundary;
    info.overfull_edges = census.overfull;
    info.mismatched_edges = census.mismatched;
    info.shells = census.shells;
    info.closed = census.edges > 0 && census.unbalanced == 0;
}

Result<MeshInfo> inspect_or_throw(const MeshView& mesh, const InspectOptions& options) {
    const Parallel parallel(options.control);
    parallel.begin_stage(box_share);
    Result<MeshInfo> info =
        measure_mesh(mesh, options.transform, options.unit_mm, parallel, [&] { parallel.begin_stage(measure_share); });
    if (!info) {
        return info;
    }
    parallel.begin_stage(census_share, 4);
    add_census(count_edges(mesh, options.transform, info->unit_mm, parallel), *info);
    if (info->degenerate == info->triangles) {
        return all_collapsed(info->triangles, info->unit_mm);
    }
    parallel.finish();
    return info;
}

}  // namespace

Result<MeshInfo> inspect(const MeshView& mesh, const InspectOptions& options) noexcept {
    return guarded(options.control, [&] { return inspect_or_throw(mesh, options); });
}

}  // namespace lamella
