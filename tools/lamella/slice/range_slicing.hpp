// lamella slice --memory: a mesh larger than memory, and what it makes of the other options.
#pragma once

#include "lamella/slice_file.hpp"
#include "outputs/output_formats.hpp"
#include "outputs/streamed_outputs.hpp"
#include "slice/slice_arguments.hpp"
#include "slice/slice_summary.hpp"
#include "terminal/console.hpp"
#include "terminal/interrupt.hpp"

namespace lamella::cli {

/// Throws Failure (bad_usage) where --memory cannot be had together with the report or with standard input.
void require_ranges_possible(const SliceArguments& arguments);

/// The mesh as far as its file's beginning says. Throws Failure.
MeshFile describe_mesh_of(const SliceArguments& arguments);

/// What is known of `mesh` before it is sliced with `options` within --memory. Throws Failure.
FileOutline outline_within_memory(const std::string& mesh, const SliceArguments& arguments, const SliceOptions& options);

/// Slices within --memory. Where the `outputs` take layers as they are cut, the result has layers and closed gaps only;
/// null: it holds everything. Fills in `run`. Errors: those of slice_file(). Throws Failure where an output cannot be
/// written.
Result<SliceResult> slice_in_ranges(const SliceArguments& arguments, const SliceOptions& options, StreamedOutputs* outputs,
                                    ToolRun& run);

}  // namespace lamella::cli
