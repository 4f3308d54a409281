// The stages of lamella slice, in their order. All throw Failure.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lamella/io/mesh_file.hpp"
#include "lamella/io/svg.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/medical/table.hpp"
#include "lamella/mesh/orient.hpp"
#include "lamella/mesh/weld.hpp"
#include "lamella/slice_file.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

/// The outputs, before any work is done. (bad_usage, bad_output) where an output or the report could not be written, or
/// would overwrite a mesh, the file of another option or another output.
std::vector<PlannedOutput> plan_slice_outputs(const SliceArguments& arguments);

/// All files that come of them, with the report.
std::vector<std::filesystem::path> files_to_write(const SliceArguments& arguments,
                                                  const std::vector<PlannedOutput>& outputs);

/// The mesh, or within --memory what its file's beginning says of it.
MeshFile read_for_slicing(const SliceArguments& arguments, Stages& stages);

/// The image of --like, if there is one, or the voxels of --spacing around all meshes.
ImageGeometry image_for(const std::vector<MeshFile>& files, const SliceArguments& arguments);

/// Takes the place of a mesh as its file has it.
struct MendedMesh {
    std::optional<WeldedMesh> welded{};
    std::optional<OrientedMesh> oriented{};  ///< after welding
};

/// By --weld and --orient-shells. Fills in `run`.
MendedMesh mend_mesh(const MeshFile& mesh, const SliceArguments& arguments, Stages& stages, ToolRun& run);

/// Outputs of a mesh larger than memory, that are written while it is sliced: each layer is cut, written, forgotten.
class StreamedOutputs {
public:
    /// True if all of them are of formats that take one layer after the other: SVG and tables.
    static bool serve(const std::vector<PlannedOutput>& outputs);

    /// `mesh_name`: of the rows of tables. `image`: at whose slices the mesh is cut, or null; it must outlive this.
    StreamedOutputs(std::vector<PlannedOutput> outputs, std::string mesh_name, const ImageGeometry* image);

    /// The result has layers and closed gaps only. Fills in `run`. Errors: those of slice_file(). Throws Failure where an
    /// output cannot be written.
    Result<SliceResult> slice(const std::string& mesh, FileSliceOptions options, ToolRun& run);

    /// Takes a layer from slice_file().
    void operator()(const LayerView& view) noexcept;

    /// Puts the files in their places, or none where some failed before. Throws Failure.
    void finish();

private:
    using Stream = std::variant<SvgStream, LayerTableStream>;

    static bool has_failed(const Stream& stream) noexcept;
    Result<Stream> open(const PlannedOutput& output, const FileOutline& outline) const;
    void begin(const FileOutline& outline) noexcept;
    bool failed() const noexcept;

    std::vector<PlannedOutput> outputs_;
    std::string mesh_name_;
    const ImageGeometry* image_;
    std::vector<Stream> streams_;
    Status begun_;
    SliceResult facts_;  ///< what the summary tells of, as the following
    std::vector<Layer> layers_;
    std::vector<ClosedGap> gaps_;
    OpenLayers open_;
    StopCheck stop_;
    std::atomic<bool> out_of_memory_ = false;
};

/// Slices within --memory. The `outputs` take layers as they are cut; null: the result holds everything. Fills in `run`.
/// Errors: those of slice_file().
Result<SliceResult> slice_in_ranges(const std::string& mesh, const FileSliceOptions& options, StreamedOutputs* outputs,
                                    ToolRun& run);

/// `streamed`: outputs that take layers as they are cut, or null. Fills in `run`.
SliceResult cut_mesh(const MeshFile& mesh, const MendedMesh& mended, SliceOptions options, const SliceArguments& arguments,
                     StreamedOutputs* streamed, Stages& stages, ToolRun& run);

/// Warnings of open layers, layers of which nothing is cut or left, solid that is taken away, doubts of the mesh's scale.
/// `contours`: of a result that keeps its layers only. `image`: whose slices were cut.
std::vector<std::string> warnings_of(const SlicedPart& part, std::optional<std::uint64_t> contours,
                                     const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image);

}  // namespace lamella::cli
