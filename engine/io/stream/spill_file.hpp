// Triangles that wait for their layers on disk.
//
//     file     run 0: | bin 0 | bin 1 | ... |   run 1: | bin 0 | bin 1 | ... |   ...
//
// A run is what memory held when it was full; a bin, a range of layers that the triangles begin in. Every run has the same
// bins, so that a range of layers is a few large pieces of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "io/stream/triangle_store.hpp"
#include "lamella/array.hpp"

namespace lamella {

class SpillFile {
public:
    /// A file in `folder` without a name, with bins that begin about equally many of the triangles counted. Throws Refused
    /// (unwritable_file).
    SpillFile(const std::filesystem::path& folder, const PlaneCounts& counts);
    ~SpillFile();
    SpillFile(const SpillFile&) = delete;
    SpillFile& operator=(const SpillFile&) = delete;

    /// Adds a run, sorted in place first. A triangle that begins below plane `done` counts as one that begins there. Throws
    /// Refused, Stopped.
    void write(std::span<CrossedTriangle> triangles, PlaneIndex done, const Parallel& parallel);

    /// Appends to `store` all triangles that begin in planes [begin, end), by the same rule. `piece`: how many to read at
    /// once. Throws Refused, Stopped.
    void load(PlaneIndex begin, PlaneIndex end, PlaneIndex done, std::size_t piece, const Parallel& parallel,
              TriangleStore& store);

    std::uint64_t bytes() const noexcept { return triangles_ * sizeof(CrossedTriangle); }

private:
    struct Run {
        std::vector<std::uint64_t> bin_begin;  ///< in triangles of the file; one more than bins
    };

    Error failed(const char* what) const;

    std::filesystem::path folder_;
    int descriptor_ = -1;
    std::vector<PlaneIndex> bin_planes_;  ///< first plane of each bin, and one past the last
    std::vector<Run> runs_;
    std::vector<Array<CrossedTriangle>> buffers_;  ///< by thread
    std::uint64_t triangles_ = 0;
};

}  // namespace lamella
