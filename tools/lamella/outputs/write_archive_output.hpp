// Results as HDF5 archives.
#pragma once

#include "lamella/control.hpp"
#include "outputs/write_outputs.hpp"

namespace lamella::cli {

/// Throws Failure (bad_usage) where an archive is wanted that this build cannot write.
void require_archive_possible(const std::vector<PlannedOutput>& outputs);

/// Precondition: the job has one part. Throws Failure.
void write_archive_output(const OutputJob& job, const PlannedOutput& output, const Control& control);

}  // namespace lamella::cli
