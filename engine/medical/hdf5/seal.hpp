// The first bytes of an archive, a user block of HDF5: what it is, how long, and the checksum of its tree. So damaged files
// are refused before HDF5 reads them.
//
//     lamella archive 1
//     tree 9216 5f0c1a77          bytes from the file's begin to the first column, and CRC-32 of those behind the seal
//     file 1048576                bytes
//     ...........8e21bb04         CRC-32 of the seal before it
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/read/input_file.hpp"

namespace lamella {

inline constexpr std::size_t seal_bytes = 512;

/// Writes the seal of `tree` over its first bytes.
void seal(std::span<std::byte> tree, std::uint64_t file_bytes);

/// The tree of an archive, with its seal. Throws Refused where the file is none, is cut off, or its tree is damaged.
std::vector<std::byte> read_sealed(const InputFile& file);

}  // namespace lamella
