// What the machine grants this process, and how much of it slicing a file takes.
#pragma once

#include <cstdint>
#include <string>

namespace lamella::cli::batch {

/// Processors: the lesser of what the machine has and what this process's control group grants.
int usable_threads();

/// Three quarters of the memory that they have, or what is free if that is less.
std::uint64_t usable_memory();

inline constexpr double process_bytes = 16e6;  ///< that slicing the smallest mesh takes

/// Memory that slicing a mesh is estimated to take, by the first bytes and the size of its file. O(1). A file that cannot be
/// read is estimated as empty. Peak resident sizes by format were measured with bench/scripts/batch_memory.py;
/// bench/README.md has the table.
double estimate_memory(const std::string& path, std::uint64_t file_bytes);

}  // namespace lamella::cli::batch
