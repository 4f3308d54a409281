// A file of triangles, of which any piece can be read: binary STL, or binary PLY whose vertices stay in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

class TriangleFile {
public:
    /// Errors: those of read_mesh(), and invalid_argument for what cannot be read in pieces.
    static Result<std::unique_ptr<TriangleFile>> open(const std::filesystem::path& path, std::string_view name,
                                                      double mm_per_unit, const Parallel& parallel);
    virtual ~TriangleFile() = default;
    TriangleFile(const TriangleFile&) = delete;
    TriangleFile& operator=(const TriangleFile&) = delete;

    /// What load() reads to stay in memory: the vertices of indexed triangles.
    virtual std::uint64_t resident_bytes() const noexcept { return 0; }
    /// To be called before read(). Throws Refused, Stopped, std::bad_alloc.
    virtual void load(const Memory*, const Parallel&) {}

    /// Bytes a triangle that read() needs.
    virtual std::size_t buffer_bytes() const noexcept = 0;
    /// Triangles [first, first + count) in `buffer`, aligned as by operator new. From several threads. Throws Refused, with
    /// the first triangle that is wrong.
    virtual MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer) const = 0;

    std::uint64_t triangles() const noexcept { return facts_.triangle_count; }
    /// What read_mesh() would say, without bytes.
    MeshFile& facts() noexcept { return facts_; }
    /// Errors: unreadable_file, where it changed since it was opened.
    Status unchanged() const { return file_.unchanged(); }
    /// `error` with the file's name.
    Error named(Error error) const;

protected:
    explicit TriangleFile(InputFile file) : file_(std::move(file)) {}

    /// Fills `into` from byte `offset` on. Throws Refused.
    void read_bytes(std::uint64_t offset, std::span<std::byte> into) const;

    InputFile file_;
    MeshFile facts_;
};

/// What a refusal says, and what to do.
inline constexpr std::string_view formats_in_pieces = "only binary STL and PLY can be sliced within a budget of memory; ";
inline constexpr std::string_view makes_ply = "'lamella convert MESH -o MESH.ply' makes the latter of it";

}  // namespace lamella
