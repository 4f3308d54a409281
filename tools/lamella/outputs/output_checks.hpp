// Refusals of outputs before any mesh is read, and of an image before any is sliced.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lamella/medical/geometry.hpp"
#include "lamella/result.hpp"
#include "outputs/image_arguments.hpp"
#include "outputs/output_formats.hpp"

namespace lamella::cli {

/// Files that are read, each with what messages call it.
using NamedInputs = std::vector<std::pair<std::string, std::string>>;

/// Throws Failure (bad_usage) where `file`, which `option` names, is one of the inputs.
void require_no_input(const std::string& file, const NamedInputs& inputs, const std::string& option);

/// Throws Failure (bad_usage) where options and formats do not go together, wherever the files may lie.
void require_together(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments, std::size_t meshes,
                      bool image_given, int subslices);

/// The outputs that are asked for, if any. Throws Failure (bad_usage, bad_output) where they do not go together, plainly
/// cannot be written, or would overwrite an input.
std::vector<PlannedOutput> plan_outputs(const OutputArguments& arguments, std::size_t meshes, bool image_given,
                                        int subslices, const NamedInputs& inputs);

/// All files that come of them.
std::vector<std::filesystem::path> files_of(const std::vector<PlannedOutput>& outputs, bool several_meshes);

/// Throws Failure (bad_usage) where one of the outputs would replace a slice of the image's series.
void require_series_kept(const ImageGeometry& image, const std::vector<std::filesystem::path>& outputs);

/// Throws Failure (bad_input).
void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments);

/// Throws Failure (bad_input) where the mesh lies outside of the image.
void require_overlap(const ImageGeometry& image, const std::string& name, const SliceSummary& mesh);

/// The environment's SOURCE_DATE_EPOCH, seconds since 1970, if it is there. Throws Failure (bad_usage).
std::optional<std::int64_t> source_date();

}  // namespace lamella::cli
