// What follows the header of a PLY file.
#pragma once

#include <cstdint>
#include <string_view>

#include "base/parallel.hpp"
#include "io/read/ply/ply_header.hpp"
#include "lamella/array.hpp"
#include "lamella/memory.hpp"
#include "lamella/mesh.hpp"

namespace lamella {

struct PlyInput {
    std::string_view file;  ///< with the header
    const PlyHeader& header;
    std::uint64_t memory_limit;
    const Parallel& parallel;
};

struct PlyMesh {
    explicit PlyMesh(const Memory* memory) : coordinates(memory), indices(memory) {}

    Array<std::byte> coordinates;  ///< empty where they are used where they lie
    std::size_t first_offset = 0;  ///< in `coordinates` or the file
    std::size_t stride = 0;
    CoordinateType coordinate_type = CoordinateType::f32;
    bool swapped = false;  ///< the file's byte order is not the machine's, and the coordinates are still the file's
    std::uint64_t vertex_count = 0;
    Array<std::uint32_t> indices;
    std::uint64_t small_faces = 0;  ///< left out: of fewer than three vertices
    LeftOut long_rows;              ///< lines with more words than their row takes, which are ignored
    std::size_t end = 0;            ///< of the last element in the file
};

/// Doubles and integers of 32 bits are kept as doubles.
CoordinateType number_for(const PlyElement& vertices) noexcept;

constexpr std::size_t size_of(CoordinateType number) noexcept {
    return number == CoordinateType::f64 ? sizeof(double) : sizeof(float);
}

/// Sets up the vertices of `mesh` in an array of their own, whose contents are still to be written.
void allocate_vertices(const PlyElement& vertices, PlyMesh& mesh);

/// False: `problem` holds the first one, whatever the number of threads.
bool read_ply_body(const PlyInput& input, PlyMesh& mesh, PlyProblem& problem);

}  // namespace lamella
