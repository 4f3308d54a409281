// What follows the header of a PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/parallel.hpp"
#include "io/read/faces.hpp"
#include "io/read/ply/ply_header.hpp"

namespace lamella {

struct PlyInput {
    const FileSource& source;
    std::string_view file;  ///< with the header
    const PlyHeader& header;

    const Parallel& parallel() const noexcept { return source.parallel(); }
    bool swapped() const noexcept { return header.encoding == PlyEncoding::big_endian; }
};

/// What is to be known of a body beside the mesh.
struct PlyBody {
    bool swapped = false;           ///< the file's byte order is not the machine's, and the coordinates are still the file's
    std::uint64_t small_faces = 0;  ///< left out: of fewer than three vertices
    LeftOut long_rows;              ///< lines with more words than their row takes, which are ignored
    std::size_t end = 0;            ///< of the last element in the file
};

/// Doubles and integers of 32 bits are kept as doubles.
CoordinateType number_for(const PlyElement& vertices) noexcept;

/// Fills in the vertices and indices of `mesh`. It has no bytes where coordinates are used where they lie in the file.
/// Throws the first error in the body, whatever the number of threads.
PlyBody read_ply_body(const PlyInput& input, MeshFile& mesh);

/// ASCII PLY as nearly everyone writes it, one row a line, parsed in parallel. Lines may have more words than the header
/// declares, which are ignored and counted, if `takes_long_rows`. False: rows are no lines, or something is wrong, which a
/// reader that goes from number to number will find. Whether it succeeds, and what it makes, does not depend on threads.
bool read_ply_lines(const PlyInput& input, bool takes_long_rows, MeshFile& mesh, PlyBody& body);

}  // namespace lamella
