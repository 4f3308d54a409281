// STL files, binary and ASCII. Which of the two a file is, is decided by its size and content, never by the word "solid"
// alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lamella/array.hpp"
#include "lamella/mesh.hpp"
#include "lamella/status.hpp"

namespace lamella {

/// A mesh read from a file, with its memory. A binary file is kept as its bytes (no parse, no copy); an ASCII one as nine
/// floats a triangle.
struct StlMesh {
    Array<std::byte> bytes;        ///< binary: the whole file; ASCII: packed floats
    std::size_t first_offset = 0;  ///< of the first triangle's vertices in `bytes`
    std::size_t stride = 0;        ///< bytes between triangles
    std::uint64_t triangle_count = 0;
    bool ascii = false;
    std::vector<std::string> warnings;  ///< one line each, naming the file
    std::uint64_t file_bytes = 0;
    double read_ms = 0;   ///< getting the bytes
    double parse_ms = 0;  ///< making triangles of them (ASCII)

    MeshView view() const noexcept {
        return MeshView::strided_soup(bytes.data() + first_offset, triangle_count, stride, Number::f32);
    }
};

struct StlReadOptions {
    int threads = 0;                              ///< 0: all that the host's task arena allows
    std::pmr::memory_resource* memory = nullptr;  ///< null: operator new
    /// Map the file instead of reading it. Saves the copy; a file that shrinks while it is mapped kills the process, so this
    /// is for programs that own their input.
    bool map_file = false;
};

/// Reads `path`. Errors: unreadable_file, malformed_mesh (with the byte offset, and for ASCII the line, in the message),
/// empty_mesh. Never allocates by a count that the file does not hold.
Result<StlMesh> read_stl(const std::filesystem::path& path, const StlReadOptions& options = {}) noexcept;

}  // namespace lamella
