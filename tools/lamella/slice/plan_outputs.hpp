// What can be known of the outputs of lamella slice before any work is done.
#pragma once

#include <filesystem>
#include <vector>

#include "outputs/output_formats.hpp"
#include "slice/slice_arguments.hpp"

namespace lamella::cli {

/// Throws Failure (bad_usage, bad_output) where an output or the report could not be written, or would overwrite a mesh,
/// the file of another option or another output.
std::vector<PlannedOutput> planned_outputs_of(const SliceArguments& arguments);

/// All files that come of them, with the report.
std::vector<std::filesystem::path> files_to_write(const SliceArguments& arguments,
                                                  const std::vector<PlannedOutput>& outputs);

}  // namespace lamella::cli
