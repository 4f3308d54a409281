// The first pass over a file of triangles: its box, and what the second pass skips and waits for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.hpp"
#include "io/stream/triangle_file.hpp"
#include "lamella/error.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// Of so many triangles of the file as are read at once. Heights are those after the transform.
struct FileChunk {
    double low_mm;
    double high_mm;
    double low_from_here_mm;  ///< the least of this chunk and of all that come after it
    bool near;                ///< some triangle may have two equal vertices on the grid
};

struct FileBox {
    Bounds bounds;
    std::vector<FileChunk> chunks;
};

/// Reads all of `file`, in chunks of `chunk_triangles`. `asked_mm`: the grid unit asked for, or 0. Errors name the
/// file: bad_coordinate (with the triangle), and those of TriangleFile::read(). Throws Stopped, std::bad_alloc.
Result<FileBox> measure_file(const TriangleFile& file, const Transform& transform, double asked_mm,
                             std::size_t chunk_triangles, const Parallel& parallel, ProgressMeter& progress);

}  // namespace lamella
