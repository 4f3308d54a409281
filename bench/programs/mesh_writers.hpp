// Writes a mesh in every format that the library reads, as common programs write it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "lamella/mesh/weld.hpp"

namespace lamella::bench {

enum class Encoding : std::uint8_t { text, binary, packed };

struct MeshWriter {
    std::string_view name;
    std::string_view extension;
    Encoding encoding;
    /// Writes `mesh`, whose coordinates are floats. Returns its number of bytes before compression; 0 on failure.
    std::uint64_t (*write)(const WeldedMesh& mesh, const std::filesystem::path& file);
};

std::span<const MeshWriter> mesh_writers() noexcept;

}  // namespace lamella::bench
