// A file as bytes: opened once, checked to be a regular file, read by large parallel preads or mapped, and checked at the
// end not to have changed meanwhile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/io/name_text.hpp"

namespace lamella {

/// True if the file's name ends in `extension`, given as ".stl", in any case. A file that is called ".stl" has none.
bool has_extension(std::string_view path, std::string_view extension) noexcept;

/// Fills `into` from byte `offset` on. Returns 0, the error number, or -1 where the file ends before.
int read_fully(int descriptor, std::span<std::byte> into, std::uint64_t offset);

class InputFile {
public:
    /// Opens without ever waiting (a FIFO would), and refuses what is not a regular file. Messages call it `name`, or by its
    /// path.
    static Result<InputFile> open(const std::filesystem::path& path, std::string_view name = {});

    InputFile(InputFile&& other) noexcept;
    InputFile& operator=(InputFile&&) = delete;
    ~InputFile();

    const std::string& name() const noexcept { return name_; }  ///< printable, for messages
    std::uint64_t size() const noexcept { return size_; }       ///< when it was opened

    /// Fills `into` from byte 0 on. Precondition: into.size() <= size().
    Status read(std::span<std::byte> into, const Parallel& parallel) const;

    /// Fills `into` from byte `offset` on, on the calling thread. From several threads at once. Precondition: it lies within
    /// the size.
    Status read_at(std::uint64_t offset, std::span<std::byte> into) const;

    /// The first `count` bytes mapped privately; the array unmaps them in the end. Precondition: 0 < count <= size().
    Result<Array<std::byte>> map(std::size_t count) const;

    /// An error if the file's size or time of change differ from when it was opened.
    Status unchanged() const;

    Error error(ErrorCode code, const std::string& what, std::int64_t byte_offset = -1) const;

private:
    InputFile(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}

    int descriptor_;
    std::string name_;
    std::uint64_t size_ = 0;
    std::int64_t changed_s_ = 0;
    std::int64_t changed_ns_ = 0;
};

}  // namespace lamella
