// lamella slice --spacing: voxels around all meshes.
#pragma once

#include <vector>

#include "lamella/medical/geometry.hpp"
#include "slice/slice_arguments.hpp"

namespace lamella::cli {

/// Throws Failure: a mesh that cannot be sliced, or whose patient frame is unknown; a spacing that is none.
ImageGeometry image_around(const std::vector<MeshFile>& files, const SliceArguments& arguments);

}  // namespace lamella::cli
