// slice() for callers within the library: on a grid and at planes that are chosen already, or for another output.
#pragma once

#include "lamella/slice.hpp"
#include "slicing/planes/shared_frame.hpp"
#include "slicing/result/slice_output.hpp"

namespace lamella::detail {

struct PartSlicer {
    /// Where `frame` is null, of the mesh's own. Throws what slicing throws.
    static Status slice(const MeshView& mesh, const SliceOptions& options, const SharedFrame* frame, Workspace& workspace,
                        SliceResult& result);
    /// For `output`; `result` gets what is not in layers.
    static Status slice_for(SliceOutput& output, const MeshView& mesh, const SliceOptions& options, const SharedFrame* frame,
                            Workspace& workspace, SliceResult& result);
    /// Everything up to the count of crossings: what `output` admits, and no more.
    static Status admit(SliceOutput& output, const MeshView& mesh, const SliceOptions& options, Workspace& workspace,
                        SliceResult& result);
};

}  // namespace lamella::detail
