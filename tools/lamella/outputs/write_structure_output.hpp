// Results become structure sets.
#pragma once

#include <functional>
#include <string>

#include "outputs/write_outputs.hpp"

namespace lamella::cli {

/// Dated by the environment's SOURCE_DATE_EPOCH, seconds since 1970, if it is there. `note` takes warnings. Throws Failure.
void write_structure_output(const OutputJob& job, const PlannedOutput& output, const Control& control,
                            const std::function<void(const std::string&)>& note);

/// What can be refused before any mesh is read. Throws Failure (bad_usage).
void require_structures_possible(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments,
                                 bool image_given, int subslices);

/// What can be refused of an image before any mesh is sliced. Throws Failure (bad_input).
void require_image_serves(const ImageGeometry& image, const std::vector<PlannedOutput>& outputs,
                          const OutputArguments& arguments);

/// Throws Failure (bad_input) where the mesh lies outside of the image.
void require_overlap(const ImageGeometry& image, const std::string& name, const SliceSummary& mesh);

}  // namespace lamella::cli
