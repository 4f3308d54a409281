// A file of triangles, of which any piece can be read: binary STL, or binary PLY whose vertices stay in memory.
#pragma once

#include <memory>
#include <utility>

#include "base/guard.hpp"
#include "io/read/input_file.hpp"
#include "lamella/io/mesh_file.hpp"

namespace lamella {

class TriangleFile {
public:
    /// Throws Refused: as read_mesh(), and invalid_argument for what cannot be read in pieces.
    static std::unique_ptr<TriangleFile> open(const std::filesystem::path& path, const ReadOptions& options);
    virtual ~TriangleFile() = default;
    TriangleFile(const TriangleFile&) = delete;
    TriangleFile& operator=(const TriangleFile&) = delete;

    /// Bytes that load() gives, to stay in memory: the vertices of indexed triangles.
    virtual std::uint64_t resident_bytes() const noexcept { return 0; }
    /// Throws Refused, Stopped, std::bad_alloc.
    virtual Array<std::byte> load(const Parallel& parallel) const { return Array<std::byte>(parallel.memory()); }

    /// Bytes a triangle that read() needs.
    virtual std::size_t buffer_bytes() const noexcept = 0;
    /// Triangles [first, first + count) in `buffer`, aligned as by operator new, and `resident`, which load() gave. From
    /// several threads. Throws Refused, with the first triangle that is wrong.
    virtual MeshView read(std::uint64_t first, std::size_t count, std::span<std::byte> buffer,
                          std::span<const std::byte> resident) const = 0;

    std::uint64_t triangles() const noexcept { return facts_.triangle_count; }
    /// As read_mesh() would give it, without bytes.
    const MeshFile& facts() const noexcept { return facts_; }
    /// Throws Refused (unreadable_file) where it changed since it was opened.
    void must_be_unchanged() const { require(file_.unchanged()); }
    /// Throws Refused, with the file's name.
    [[noreturn]] void refuse(Error error) const {
        error.message = file_.name() + ": " + error.message;
        throw Refused{std::move(error)};
    }

protected:
    explicit TriangleFile(InputFile file) : file_(std::move(file)) {}

    /// Fills `into` from byte `offset` on. Throws Refused.
    void read_bytes(std::uint64_t offset, std::span<std::byte> into) const { require(file_.read_at(offset, into)); }

    InputFile file_;
    MeshFile facts_;
};

}  // namespace lamella
