// The stages of lamella slice, in their order. All throw Failure.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lamella/io/mesh_file.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/mesh/orient.hpp"
#include "lamella/mesh/weld.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"
#include "slice/streamed_outputs.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

/// What is to be written, before any work is done. (bad_usage, bad_output) where an output or the report could not be
/// written, or would overwrite a mesh, the file of another option or another output.
std::vector<PlannedOutput> plan_slice_outputs(const SliceArguments& arguments);

/// All files that come of them, with the report.
std::vector<std::filesystem::path> files_to_write(const SliceArguments& arguments,
                                                  const std::vector<PlannedOutput>& outputs);

/// The mesh, or within --memory what its file's beginning says of it.
MeshFile read_for_slicing(const SliceArguments& arguments, Stages& stages);

/// The image of --like, if there is one, or the voxels of --spacing around all meshes.
ImageGeometry image_for(const std::vector<MeshFile>& files, const SliceArguments& arguments);

/// What is sliced in place of a mesh as its file has it.
struct MendedMesh {
    std::optional<WeldedMesh> welded{};
    std::optional<OrientedMesh> oriented{};  ///< after welding
};

/// By --weld and --orient-shells. Fills in `run`.
MendedMesh mend_mesh(const MeshFile& mesh, const SliceArguments& arguments, Stages& stages, ToolRun& run);

/// `streamed`: outputs that take layers as they are cut, or null. Fills in `run`.
SliceResult cut_mesh(const MeshFile& mesh, const MendedMesh& mended, SliceOptions options, const SliceArguments& arguments,
                     StreamedOutputs* streamed, Stages& stages, ToolRun& run);

/// What to warn of: open layers, layers of which nothing is cut or left, solid that is taken away, doubts of the mesh's
/// scale. `contours`: of a result that keeps its layers only. `image`: whose slices were cut.
std::vector<std::string> warnings_of(const SlicedPart& part, std::optional<std::uint64_t> contours,
                                     const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image);

}  // namespace lamella::cli
