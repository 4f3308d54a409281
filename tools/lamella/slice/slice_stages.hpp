// The stages of lamella slice: the mesh that is read and mended, its image, what is warned of, and outputs that are written
// while it is sliced; and the summary for people, with the members that the tool adds to the report.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lamella/io/mesh_stream.hpp"
#include "lamella/io/report.hpp"
#include "lamella/medical/geometry.hpp"
#include "lamella/weld.hpp"
#include "outputs/write_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "slicing/tuning.hpp"
#include "terminal/stages.hpp"

namespace lamella::cli {

/// The tool's own work on the mesh that was sliced last, and the time that it took.
struct ToolRun {
    std::vector<std::string> outputs{};  ///< the files that were written, or -
    /// Stages of the tool, by the names of the report. That of the report itself, which has only the making, is "report".
    std::map<std::string_view, double> ms{};
    std::uint64_t peak_rss_bytes = 0;
    std::vector<std::string> warnings{};
    std::uint64_t shells = 0;         ///< looked at by --orient-shells
    std::uint64_t turned_shells = 0;  ///< of these
    std::optional<RandomHeights> random_heights{};
    bool print_hash = false;
    std::string ranges{};  ///< how a mesh larger than memory was sliced, a line
};

/// The members that the tool adds to the report. They refer to `run`.
std::vector<ReportMember> members_of(const ToolRun& run);

/// Some lines, each a keyword and what there is to say, with a final newline.
std::string summary(const SlicedPart& part, const ReportParts& parts, const ToolRun& run);

/// The mesh that is sliced: a file, mended or not, or within --memory a stream of it.
struct MeshToSlice {
    MeshFile file;
    std::optional<MeshStream> stream{};      ///< in place of the file
    std::optional<WeldedMesh> welded{};      ///< in place of the file
    std::optional<OrientedMesh> oriented{};  ///< after welding
    std::vector<std::string> warnings{};     ///< of reading

    const MeshFile& about() const noexcept { return stream ? stream->about() : file; }
    /// The triangles that are sliced. Precondition: no stream.
    MeshView view() const noexcept { return oriented ? oriented->view() : welded ? welded->view() : file.view(); }
    Source source() const noexcept { return stream ? stream->view() : Source(view()); }
};

/// The mesh, or within --memory a stream of it. Throws Failure, as all that follow.
MeshToSlice read_for_slicing(const SliceArguments& arguments, Stages& stages);

/// By --weld and --orient-shells. Fills in `run`.
void mend(MeshToSlice& mesh, const SliceArguments& arguments, Stages& stages, ToolRun& run);

/// The image of --like, if there is one, or the voxels of --spacing around all meshes.
ImageGeometry image_for(const std::vector<MeshToSlice>& meshes, const SliceArguments& arguments);

/// Warnings of open layers, layers of which nothing is cut or left, solid that is taken away, doubts of the mesh's scale.
/// `image`: whose slices were cut.
std::vector<std::string> warnings_of(const SlicedPart& part, const SliceArguments& arguments, const MeshFile& mesh,
                                     const std::optional<ImageGeometry>& image);

/// True if all outputs are of formats that take one layer after the other: SVG and tables.
bool can_stream(const std::vector<PlannedOutput>& outputs);

/// Slices a mesh larger than memory: each layer is cut, written, forgotten. The part's result gets layers and stitches only;
/// its open layers, and its hash where `hash` asks for it or an output has a record, are found on the way. Returns what puts
/// the files in their places. Throws Failure, also where an output cannot be written; none is in its place then.
std::function<void()> slice_streamed(const OutputJob& job, SlicedPart& part, const Source& mesh, const SliceOptions& options,
                                     const Tuning& tuning, bool hash, Context context);

}  // namespace lamella::cli
