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
#include "base/system/file.hpp"
#include "lamella/array.hpp"
#include "lamella/error.hpp"
#include "lamella/io/name_text.hpp"

namespace lamella {

/// A path in the characters of the system's names.
using PathView = std::basic_string_view<std::filesystem::path::value_type>;

/// True if the file's name ends in `extension`, given as ".stl", in any case. A file that is called ".stl" has none.
bool has_extension(PathView path, std::string_view extension) noexcept;

class InputFile {
public:
    /// Opens without ever waiting (a FIFO would), and refuses what is not a regular file. Messages call it `name`, or by its
    /// path.
    static Result<InputFile> open(const std::filesystem::path& path, std::string_view name = {});

    const std::string& name() const noexcept { return name_; }    ///< printable, for messages
    std::uint64_t size() const noexcept { return opened_.size; }  ///< when it was opened
    const std::filesystem::path& folder() const noexcept { return folder_; }

    /// Fills `into` from byte 0 on. Precondition: into.size() <= size().
    Status read(std::span<std::byte> into, const Parallel& parallel) const;

    /// Fills `into` from byte `offset` on, on the calling thread. From several threads at once. Precondition: it lies within
    /// the size.
    Status read_at(std::uint64_t offset, std::span<std::byte> into) const;

    /// The first `count` bytes, mapped privately. Precondition: the system maps files, 0 < count <= size().
    Result<Array<std::byte>> map(std::size_t count) const;

    /// An error if the file's size or time of change differ from when it was opened.
    Status unchanged() const;

    Error error(ErrorCode code, const std::string& what, std::int64_t byte_offset = -1) const;

private:
    explicit InputFile(std::string name) : name_(std::move(name)) {}

    File file_;
    std::string name_;
    std::filesystem::path folder_;
    FileStatus opened_;
};

}  // namespace lamella
