// lamella slice --memory: a mesh larger than memory, sliced in ranges of layers, and outputs that are written meanwhile.
#pragma once

#include <atomic>
#include <string>
#include <variant>
#include <vector>

#include "lamella/io/svg.hpp"
#include "lamella/medical/table.hpp"
#include "lamella/slice_file.hpp"
#include "outputs/output_formats.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"

namespace lamella::cli {

/// Each layer is cut, written, forgotten.
class StreamedOutputs {
public:
    /// Whether all of them are of formats that take one layer after the other: SVG and tables.
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

/// Throws Failure (bad_usage) where --memory cannot be had together with the report or with standard input.
void require_ranges_possible(const SliceArguments& arguments);

/// How to slice the file within --memory. Throws Failure (bad_usage).
FileSliceOptions file_options(const SliceArguments& arguments, const SliceOptions& options);

/// Slices within --memory. The `outputs` take layers as they are cut; null: the result holds everything. Fills in `run`.
/// Errors: those of slice_file(). Throws Failure where an output cannot be written.
Result<SliceResult> slice_in_ranges(const SliceArguments& arguments, const SliceOptions& options, StreamedOutputs* outputs,
                                    ToolRun& run);

}  // namespace lamella::cli
