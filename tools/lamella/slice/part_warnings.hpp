// What lamella slice warns of a mesh that it has cut.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lamella/io/mesh_file.hpp"
#include "lamella/medical/geometry.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"

namespace lamella::cli {

/// Open layers, layers of which nothing is cut or left, solid that is taken away, doubts of the mesh's scale. `contours`: of
/// a result that keeps its layers only. `image`: whose slices were cut.
std::vector<std::string> warnings_of(const SlicedPart& part, std::optional<std::uint64_t> contours,
                                     const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image);

}  // namespace lamella::cli
