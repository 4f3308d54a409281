// The first pass over a file of triangles: its box, and what the second pass skips and waits for.
#pragma once

#include <vector>

#include "io/stream/triangle_file.hpp"
#include "slicing/grid/bounds.hpp"

namespace lamella {

/// So many triangles of the file as are read at once. Heights are those after the transform.
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

/// Reads all of `file`, in chunks of `chunk_triangles`. `asked_mm`: the grid unit asked for, or 0. Throws
/// Refused, with the file's name: bad_coordinate (with the triangle), and as TriangleFile::read(); Stopped, std::bad_alloc.
FileBox measure_file(const TriangleFile& file, std::span<const std::byte> resident, const Placing& placing, double asked_mm,
                     std::size_t chunk_triangles, const Parallel& parallel);

}  // namespace lamella
