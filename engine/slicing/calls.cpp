// Where calls of slices enter: a mesh or a prepared one, to a result, to a sink or to the host's arrays.
#include <utility>

#include "base/guard.hpp"
#include "lamella/host_output.hpp"
#include "lamella/prepare.hpp"
#include "lamella/sink.hpp"
#include "lamella/slice.hpp"
#include "slicing/buckets/mesh_source.hpp"
#include "slicing/buckets/prepared_source.hpp"
#include "slicing/handover/host_target.hpp"
#include "slicing/handover/sink_target.hpp"
#include "slicing/slice_layers.hpp"

namespace lamella {

namespace {

using detail::PreparedParts;
using detail::WorkspaceParts;

/// A prepared mesh has its grid and its frame already.
void check_prepared(const PreparedParts& prepared, const SliceOptions& options) {
    if (options.unit_mm != 0 && options.unit_mm != prepared.asked_unit_mm && options.unit_mm != prepared.frame.unit.mm) {
        throw Refused{{ErrorCode::invalid_argument, "the mesh was prepared on another grid than the one asked for"}};
    }
    if (!options.transform.is_identity() && !(options.transform == prepared.transform)) {
        throw Refused{{ErrorCode::invalid_argument, "the mesh was prepared with another transform than the one asked for"}};
    }
}

/// Calls use(source, what the workspace keeps) with the source of a mesh.
template <class Use>
void with_source(const MeshView& mesh, const SliceOptions& options, Workspace& workspace, Use use) {
    check_options(options);
    WorkspaceParts& kept = WorkspaceParts::of(workspace, options.control);
    with_mesh_source(mesh, options.transform, nullptr, kept.source_tools(),
                     [&](TriangleSource& source) { use(source, kept); });
}
template <class Use>
void with_source(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace, Use use) {
    check_prepared(mesh.parts(), options);
    check_options(options);
    WorkspaceParts& kept = WorkspaceParts::of(workspace, options.control);
    PreparedSource source(mesh.parts(), kept.source_tools());
    use(source, kept);
}

template <class Mesh>
void slice_to_result(const Mesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) {
    with_source(mesh, options, workspace, [&](TriangleSource& source, WorkspaceParts& kept) {
        if (result.points.memory() != options.control.memory) {
            result = SliceResult(options.control.memory);
        }
        ResultTarget target;
        slice_layers(source, target, options, kept, result);
    });
}

template <class Mesh>
Result<SliceResult> slice_once(const Mesh& mesh, const SliceOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        Workspace workspace;
        SliceResult result(options.control.memory);
        slice_to_result(mesh, options, workspace, result);
        return result;
    });
}

template <class Mesh>
Status slice_again(const Mesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded(options.control, [&] {
        slice_to_result(mesh, options, workspace, result);
        return Status();
    });
}

template <class Mesh>
Result<SliceTotals> hand_over(const LayerSink& sink, const Mesh& mesh, const SliceOptions& options,
                              Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        SliceTotals totals;
        with_source(mesh, options, workspace, [&](TriangleSource& source, WorkspaceParts& kept) {
            totals = slice_to_sink(sink, source, options, kept);
        });
        return totals;
    });
}

template <class Mesh>
Result<SliceTotals> write_into(const HostOutput& output, const Mesh& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        HostTarget target(output);
        SliceResult result(options.control.memory);
        with_source(mesh, options, workspace, [&](TriangleSource& source, WorkspaceParts& kept) {
            slice_layers(source, target, options, kept, result);
        });
        return target.totals(result);
    });
}

template <class Mesh>
Result<OutputBounds> count_output(const Mesh& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<OutputBounds> {
        OutputBounds bounds;
        with_source(mesh, options, workspace, [&](TriangleSource& source, WorkspaceParts& kept) {
            SliceResult result(options.control.memory);
            count_layers(source, options, kept, result);
            const std::uint64_t segments = kept.buckets.segment_count;
            bounds = {.layers = kept.planes.size(),
                      .contours = segments,
                      .points = 2 * segments,
                      .segments = segments,
                      .are_certain = options.region.keeps_contours(),
                      .unit_mm = result.unit_mm};
        });
        return bounds;
    });
}

}  // namespace

Result<SliceResult> slice(const MeshView& mesh, const SliceOptions& options) noexcept {
    return slice_once(mesh, options);
}
Result<SliceResult> slice(const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    return slice_once(mesh, options);
}
Status slice(const MeshView& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return slice_again(mesh, options, workspace, result);
}
Status slice(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return slice_again(mesh, options, workspace, result);
}

Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return hand_over(sink, mesh, options, workspace);
}
Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return hand_over(sink, mesh, options, workspace);
}
Result<SliceTotals> slice_to(const LayerSink& sink, const MeshView& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept {
    return hand_over(sink, mesh, options, workspace);
}
Result<SliceTotals> slice_to(const LayerSink& sink, const PreparedMesh& mesh, const SliceOptions& options,
                             Workspace& workspace) noexcept {
    return hand_over(sink, mesh, options, workspace);
}

Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return write_into(output, mesh, options, workspace);
}
Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return write_into(output, mesh, options, workspace);
}
Result<SliceTotals> slice_into(const HostOutput& output, const MeshView& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return write_into(output, mesh, options, workspace);
}
Result<SliceTotals> slice_into(const HostOutput& output, const PreparedMesh& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return write_into(output, mesh, options, workspace);
}

Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return count_output(mesh, options, workspace);
}
Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options) noexcept {
    Workspace workspace;
    return count_output(mesh, options, workspace);
}
Result<OutputBounds> bound_output(const MeshView& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    return count_output(mesh, options, workspace);
}
Result<OutputBounds> bound_output(const PreparedMesh& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    return count_output(mesh, options, workspace);
}

}  // namespace lamella
