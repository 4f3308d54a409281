// gzip files, decompressed as a whole.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/memory.hpp"

namespace lamella {

inline constexpr std::string_view gzip_magic = "\x1F\x8B";

struct Unzipped {
    Array<std::byte> contents;
    std::uint64_t ignored_bytes = 0;  ///< after the last member, being none
    std::string problem;              ///< empty if all went well
    ErrorCode code = ErrorCode::malformed_mesh;
};

/// All members of a gzip file, one after the other. Refuses what expands beyond `limit_bytes`. Memory: the contents, once,
/// and a few megabytes; nothing is allocated by what the file says of its size. Throws std::bad_alloc.
Unzipped unzip(std::span<const std::byte> file, std::uint64_t limit_bytes, const Memory* memory, const Parallel& parallel);

}  // namespace lamella
