// A binary STL file, of which any piece can be read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

class TriangleFile {
public:
    /// Bytes of a triangle in the file.
    static constexpr std::size_t stride = 50;

    /// Errors: those of read_mesh(), and invalid_argument for what cannot be read in pieces.
    static Result<TriangleFile> open(const std::filesystem::path& path, std::string_view name, double mm_per_unit,
                                     const Parallel& parallel);

    /// Triangles [first, first + count) in `buffer`, which has room for them. Throws Refused.
    MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const;

    std::uint64_t triangles() const noexcept { return facts_.triangle_count; }
    /// What read_mesh() would say, without bytes.
    MeshFile& facts() noexcept { return facts_; }
    /// Errors: unreadable_file, where it changed since it was opened.
    Status unchanged() const { return file_.unchanged(); }
    /// `error` with the file's name.
    Error named(Error error) const;

private:
    TriangleFile(InputFile file, MeshFile facts) : file_(std::move(file)), facts_(std::move(facts)) {}

    InputFile file_;
    MeshFile facts_;
};

}  // namespace lamella
