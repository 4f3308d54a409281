// A mesh as a binary file, which open_mesh() reads in pieces.
//
//     const lamella::Result<lamella::MeshFile> liver = lamella::read_mesh("liver.obj.gz");
//     if (liver) {
//         const lamella::Result<lamella::WrittenMesh> written = lamella::write_mesh(*liver, "liver.ply");
//     }
#pragma once

#include <filesystem>

#include "lamella/context.hpp"
#include "lamella/error.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

struct WrittenMesh {
    bool rounded = false;  ///< a coordinate is not a float, as STL has them
};

/// Whether write_mesh() writes files of such names: ".stl" and ".ply", in capitals too.
bool is_written_as_mesh(const std::filesystem::path& path) noexcept;

/// Writes binary STL or little-endian binary PLY, by the name's end. Coordinates stay in the unit of `mesh`, which neither
/// format states; a patient frame is stated as 3D Slicer does. PLY keeps vertices and indices as they are, soup as three
/// vertices a triangle. Normals of STL are zero, which readers take for "from the vertices".
///
/// The file is written aside and renamed when complete. O(n) time and 1 MiB of memory, on the calling thread. Errors:
/// unwritable_file; invalid_argument (another end, more triangles or vertices than the format counts, a coordinate beyond
/// floats for STL); cancelled, out_of_memory.
Result<WrittenMesh> write_mesh(const MeshFile& mesh, const std::filesystem::path& path,
                               const Context& context = {}) noexcept;

}  // namespace lamella
