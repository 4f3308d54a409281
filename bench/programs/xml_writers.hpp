// The writers of XML formats for the list in mesh_writers.cpp.
#pragma once

#include <cstdint>
#include <filesystem>

#include "lamella/mesh/weld.hpp"

namespace lamella::bench {

std::uint64_t write_vtp_ascii(const WeldedMesh& mesh, const std::filesystem::path& file);
std::uint64_t write_vtp_base64(const WeldedMesh& mesh, const std::filesystem::path& file);
std::uint64_t write_vtp_raw(const WeldedMesh& mesh, const std::filesystem::path& file);
std::uint64_t write_vtp_zlib(const WeldedMesh& mesh, const std::filesystem::path& file);
std::uint64_t write_3mf(const WeldedMesh& mesh, const std::filesystem::path& file);

}  // namespace lamella::bench
