// What killed processes left behind: files that were being written aside, beside outputs of the batch.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace lamella::cli::batch {

/// Removes files named `.NAME.PID-TIME.part` beside a target NAME, unless a process PID runs this program on this machine
/// after `patience`. Nothing else is touched. The caller holds the lock by which only one batch works on the targets.
void remove_leftovers(const std::vector<std::string>& targets, std::chrono::milliseconds patience);

}  // namespace lamella::cli::batch
