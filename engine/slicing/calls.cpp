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

AnyMeshSource source_of(const MeshView& mesh, const SliceOptions& options, WorkspaceParts& kept) {
    check_options(options);
    return {mesh, options.transform, nullptr, kept.source_tools()};
}
PreparedSource source_of(const PreparedMesh& mesh, const SliceOptions& options, WorkspaceParts& kept) {
    check_prepared(mesh.parts(), options);
    check_options(options);
    return {mesh.parts(), kept.source_tools()};
}

template <class Mesh>
void slice_for(LayerTarget& target, const Mesh& mesh, const SliceOptions& options, Workspace& workspace,
               SliceResult& result) {
    WorkspaceParts& kept = WorkspaceParts::of(workspace, options.control);
    auto source = source_of(mesh, options, kept);
    slice_layers(source, target, options, kept, result);
}

template <class Mesh>
Result<SliceResult> slice_once(const Mesh& mesh, const SliceOptions& options) noexcept {
    return guarded(options.control, [&]() -> Result<SliceResult> {
        Workspace workspace;
        SliceResult result(options.control.memory);
        ResultTarget target;
        slice_for(target, mesh, options, workspace, result);
        return result;
    });
}

template <class Mesh>
Status slice_again(const Mesh& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result) noexcept {
    return guarded(options.control, [&] {
        move_to(options.control.memory, result);
        ResultTarget target;
        slice_for(target, mesh, options, workspace, result);
        return Status();
    });
}

template <class Mesh>
Result<SliceTotals> hand_over(const LayerSink& sink, const Mesh& mesh, const SliceOptions& options,
                              Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        SinkTarget target(sink);
        SliceResult result(options.control.memory);
        slice_for(target, mesh, options, workspace, result);
        return target.totals(result);
    });
}

template <class Mesh>
Result<SliceTotals> write_into(const HostOutput& output, const Mesh& mesh, const SliceOptions& options,
                               Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<SliceTotals> {
        HostTarget target(output);
        SliceResult result(options.control.memory);
        slice_for(target, mesh, options, workspace, result);
        return target.totals(result);
    });
}

template <class Mesh>
Result<OutputBounds> count_output(const Mesh& mesh, const SliceOptions& options, Workspace& workspace) noexcept {
    return guarded(options.control, [&]() -> Result<OutputBounds> {
        WorkspaceParts& kept = WorkspaceParts::of(workspace, options.control);
        SliceResult result(options.control.memory);
        auto source = source_of(mesh, options, kept);
        count_layers(source, options, kept, result);
        const std::uint64_t segments = kept.buckets.segment_count;
        return OutputBounds{.layers = kept.planes.size(),
                            .contours = segments,
                            .points = 2 * segments,
                            .segments = segments,
                            .are_certain = options.region.keeps_contours(),
                            .unit_mm = result.unit_mm};
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
