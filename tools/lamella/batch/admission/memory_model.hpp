// How much memory slicing a file takes, estimated from its format and size alone.
//
// Peak resident sizes were measured with bench/scripts/batch_memory.py; bench/README.md has the table.
#pragma once

#include <cstdint>
#include <string>

namespace lamella::cli::batch {

struct MeshEstimate {
    double triangles = 0;
    double bytes = 0;  ///< of memory
};

inline constexpr double process_bytes = 16e6;  ///< that slicing the smallest mesh takes

/// Of the file's first bytes and its size; O(1). A file that cannot be read is estimated as empty.
MeshEstimate estimate_mesh(const std::string& path, std::uint64_t file_bytes);

}  // namespace lamella::cli::batch
