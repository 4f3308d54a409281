// One mesh written in every format that is read, as the programs that people use write it.
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
    /// Writes `mesh`, whose coordinates are floats, and returns how many bytes it was before it was packed; 0: it failed.
    std::uint64_t (*write)(const WeldedMesh& mesh, const std::filesystem::path& file);
};

std::span<const MeshWriter> mesh_writers() noexcept;

}  // namespace lamella::bench
