// Files, as every system has them: open, read and write at a place, replace, remove. Errors are numbers of <cerrno>, 0 for
// none, on Windows too; system_message() says what they mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "lamella/array.hpp"

namespace lamella {

std::string system_message(int error_number);

/// The name's bytes; on Windows, where names are UTF-16, as UTF-8.
std::string path_text(const std::filesystem::path& path);

enum class FileKind : std::uint8_t { regular, folder, fifo, socket, device };

struct FileStatus {
    FileKind kind = FileKind::regular;
    unsigned mode = 0;  ///< permissions, where the system has them
    std::uint64_t size = 0;
    std::uint64_t changed = 0;  ///< when the contents last changed, in the system's finest unit, which may wrap around
};

/// An open file, or none; move-only. Bytes are written as they are, children of the process do not inherit it, and others
/// may rename or remove it meanwhile. To open one: precondition: none is open.
class File {
public:
    /// Returned where a file ends before the bytes asked for.
    static constexpr int ended = -1;
    /// Else map() is not to be called.
#if defined(_WIN32) || defined(__EMSCRIPTEN__)
    static constexpr bool can_map = false;
#else
    static constexpr bool can_map = true;
#endif

    File() noexcept = default;
    File(File&& other) noexcept : handle_(std::exchange(other.handle_, none)) {}
    File& operator=(File&& other) noexcept {
        std::swap(handle_, other.handle_);
        return *this;
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    ~File() {
        (void)close();
    }

    bool is_open() const noexcept {
        return handle_ != none;
    }

    /// A file of any kind. Never waits, as for the other end of a FIFO.
    int open_to_read(const std::filesystem::path& path) noexcept;
    /// One that is there, from its begin, whatever its kind.
    int open_to_write(const std::filesystem::path& path) noexcept;
    /// A new one to write; EEXIST where there is one of the name.
    int create(const std::filesystem::path& path) noexcept;
    /// A new one to read and write, of a name of its own that begins with `prefix`, for this user alone. `made`: its path,
    /// or the one that could not be made. Throws std::bad_alloc.
    int create_unique(const std::filesystem::path& folder, std::string_view prefix, std::filesystem::path& made);
    /// The same, and no end of the process leaves it behind.
    int create_scratch(const std::filesystem::path& folder);
    /// The open file that has this number in the process: 1 is the standard output.
    int duplicate(int number) noexcept;

    int status(FileStatus& status) const noexcept;
    /// Permissions, as of FileStatus.
    int set_mode(unsigned mode) noexcept;

    /// Fills `into` from byte `offset` on. From several threads at once.
    int read_at(std::span<std::byte> into, std::uint64_t offset) const noexcept;
    int write_at(std::span<const std::byte> from, std::uint64_t offset) noexcept;
    /// Goes on where the last write() ended.
    int write(std::string_view text) noexcept;
    /// Some file systems report a full disk only here.
    int close() noexcept;

    /// The first bytes as a private mapping, which the array unmaps in the end, and has them read in. Throws std::bad_alloc.
    int map(std::size_t bytes, Array<std::byte>& into) const;

private:
    static constexpr std::intptr_t none = -1;
    std::intptr_t handle_ = none;
};

int status_of(const std::filesystem::path& path, FileStatus& status) noexcept;
/// Whether an existing file may be written.
int check_writable(const std::filesystem::path& path) noexcept;
/// In one step: whoever opens `to` finds the old file or the new one.
int replace_file(const std::filesystem::path& from, const std::filesystem::path& to) noexcept;
int remove_file(const std::filesystem::path& path) noexcept;
/// As create_unique(), a folder.
int create_unique_folder(const std::filesystem::path& folder, std::string_view prefix, std::filesystem::path& made);

}  // namespace lamella
