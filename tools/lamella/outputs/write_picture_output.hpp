// Results become pictures.
#pragma once

#include "outputs/write_outputs.hpp"

namespace lamella::cli {

/// A contact sheet, or the layer of --picture-layer. Slices of an image are shown as radiologists see them: the patient's
/// right at the left, front or head at the top. Throws Failure.
void write_picture_output(const OutputJob& job, const PlannedOutput& output, const Control& control);

/// What can be refused before any mesh is read. Throws Failure (bad_usage).
void require_picture_possible(const std::vector<PlannedOutput>& outputs, const OutputArguments& arguments);

}  // namespace lamella::cli
