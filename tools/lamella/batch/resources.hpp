// What the machine grants this process, and how much of it slicing a file takes.
//
// Peak resident sizes by format were measured with bench/scripts/batch_memory.py; bench/README.md has the table.
#pragma once

#include <cstdint>
#include <string>

namespace lamella::cli::batch {

/// Processors: the lesser of what the machine has and what this process's control group grants.
int usable_threads();

/// Three quarters of the memory that they have, or what is free if that is less.
std::uint64_t usable_memory();

struct MeshEstimate {
    double triangles = 0;
    double bytes = 0;  ///< of memory
};

inline constexpr double process_bytes = 16e6;  ///< that slicing the smallest mesh takes

/// Of the file's first bytes and its size; O(1). A file that cannot be read is estimated as empty.
MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes);

}  // namespace lamella::cli::batch
