// slice() for callers within the library: on a grid and at planes that are chosen already, or for another output.
#pragma once

#include "lamella/slice.hpp"
#include "slicing/buckets/listed_triangles.hpp"
#include "slicing/planes/shared_frame.hpp"
#include "slicing/result/slice_output.hpp"

namespace lamella::detail {

struct PreparedParts;

/// What is sliced: a mesh as it lies, a prepared one, or triangles in lists.
struct SliceInput {
    const MeshView& mesh;                     ///< of a prepared mesh and of lists the number of triangles only
    const SharedFrame* frame = nullptr;       ///< null: the mesh's own box chooses grid and planes
    const PreparedParts* prepared = nullptr;  ///< null: triangles are read from `mesh`
    std::uint64_t first_index = 0;            ///< of the layers that a sink gets
    const ListedTriangles* listed = nullptr;  ///< null: there are none; else there is a frame
};

/// Throws what slicing throws.
struct PartSlicer {
    static Status slice(const SliceInput& input, const SliceOptions& options, Workspace& workspace, SliceResult& result);
    /// For `output`; `result` gets what is not in layers.
    static Status slice_for(SliceOutput& output, const SliceInput& input, const SliceOptions& options, Workspace& workspace,
                            SliceResult& result);
    /// Everything up to the count of crossings: what `output` admits, and no more.
    static Status admit(SliceOutput& output, const SliceInput& input, const SliceOptions& options, Workspace& workspace,
                        SliceResult& result);
};

}  // namespace lamella::detail
