// slice() on a grid and at planes that are chosen already.
#pragma once

#include "lamella/slice.hpp"
#include "slicing/planes/shared_frame.hpp"

namespace lamella::detail {

struct PreparedParts;

struct PartSlicer {
    /// Where `frame` is null, of the mesh's own. Throws what slicing throws.
    static Status slice(const MeshView& mesh, const SliceOptions& options, const SharedFrame* frame, Workspace& workspace,
                        SliceResult& result);
    static Status slice(const PreparedParts& mesh, const SliceOptions& options, Workspace& workspace, SliceResult& result);

private:
    static Status run(const MeshView& mesh, const PreparedParts* prepared, const SliceOptions& options,
                      const SharedFrame* frame, Workspace& workspace, SliceResult& result);
};

}  // namespace lamella::detail
