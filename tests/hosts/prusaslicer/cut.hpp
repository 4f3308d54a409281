// The host's meshes, heights, transforms and exceptions as the library takes them. Part of the adapter, under its licence:
// AGPL-3.0-or-later (see adapter.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <lamella/array.hpp>
#include <lamella/sink.hpp>
#include <lamella/slabs.hpp>
#include <libslic3r/TriangleMesh.hpp>
#include <libslic3r/TriangleMeshSlicer.hpp>
#include <vector>

namespace Slic3r::lamella_adapter {

/// Called by several threads at once; may throw.
using TakeLayer = std::function<void(const lamella::LayerView& layer)>;

/// Cuts a mesh at the host's heights, in any order, and hands over the layers, each as soon as it is finished. Returns the
/// layer of each height. Throws what `take` and the host's cancelling throw, and SlicingError where the library refuses the
/// mesh.
lamella::Array<std::uint64_t> cut(const indexed_triangle_set& mesh, const std::vector<float>& heights,
                                  const Transform3d& transform, const lamella::RegionRules& rules,
                                  const std::function<void()>& throw_on_cancel, const TakeLayer& take);

/// At one height, on the calling thread.
void cut(const indexed_triangle_set& mesh, float height, const Transform3d& transform, const TakeLayer& take);

/// Which faces are projected.
struct Faces {
    bool upward;
    bool downward;
};

/// Projects faces onto layers at the host's heights. Throws as cut().
lamella::Slabs project(const indexed_triangle_set& mesh, const std::vector<float>& heights, const Transform3d& transform,
                       Faces faces, const std::function<void()>& throw_on_cancel);

}  // namespace Slic3r::lamella_adapter
