// Open files, as every system has them; names are std::filesystem's. Errors are numbers of <cerrno>, 0 for none, on Windows
// too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/function_ref.hpp"
#include "lamella/array.hpp"

namespace lamella {

std::string system_message(int error_number);
/// The number of what std::filesystem returns.
int error_number_of(const std::error_code& error) noexcept;

/// The name's bytes; on Windows, where names are UTF-16, as UTF-8.
std::string path_text(const std::filesystem::path& path);
/// The path of these bytes, the other way.
std::filesystem::path path_of(std::string_view text);
/// The path by which the system finds the file: on Windows one that is long is made absolute, and marked.
std::filesystem::path system_path(const std::filesystem::path& path);
/// False of a folder of which std::filesystem lists another: on Windows one whose name is long.
bool can_list(const std::filesystem::path& folder);

struct FileStatus {
    std::filesystem::file_type type = std::filesystem::file_type::none;
    std::uint64_t size = 0;
    std::uint64_t changed = 0;  ///< when the contents last changed, in ns since 1970, which may wrap around
    // Tell, together, whether two names are those of one file.
    std::uint64_t volume = 0;
    std::uint64_t number = 0;
};

/// Of what the path leads to, of any type, which is not opened for it.
int status_of(const std::filesystem::path& path, FileStatus& status);

/// An open file, or none; move-only. Bytes are written as they are, children of the process do not inherit it, and others
/// may rename or remove it meanwhile. To open one: precondition: none is open. May throw std::bad_alloc.
class File {
public:
    /// Returned where a file ends before the bytes asked for.
    static constexpr int ended = -1;
    /// Else there is no map().
#if defined(_WIN32) || defined(__EMSCRIPTEN__)
    static constexpr bool can_map = false;
#else
    static constexpr bool can_map = true;
#endif
    /// Another file can take the name of one that is open.
#ifdef _WIN32
    static constexpr bool can_be_replaced = false;
#else
    static constexpr bool can_be_replaced = true;
#endif

    File() noexcept = default;
    File(File&& other) noexcept : handle_(std::exchange(other.handle_, none)) {}
    File& operator=(File&&) = delete;
    ~File() {
        (void)close();
    }

    bool is_open() const noexcept {
        return handle_ != none;
    }

    /// A file of any type. Never waits, as for the other end of a FIFO.
    int open_to_read(const std::filesystem::path& path);
    /// One that is there, from its begin, whatever its type.
    int open_to_write(const std::filesystem::path& path);
    /// One to read and write, which is made with these permissions if it is not there.
    int open_or_create(const std::filesystem::path& path, unsigned mode);
    /// A new one to read and write, with these permissions; EEXIST where there is one of the name.
    int create(const std::filesystem::path& path, unsigned mode);
    /// A new one of a name of its own. `made`: its path, or the one that could not be made.
    int create_unique(const std::filesystem::path& prefix, std::string_view suffix, unsigned mode,
                      std::filesystem::path& made);
    /// A new one without a name, which no end of the process leaves behind.
    int create_scratch(const std::filesystem::path& folder);
    /// The open file that has this number in the process: 1 is the standard output.
    int duplicate(int number) noexcept;

    int status(FileStatus& status) const noexcept;
    /// By which this process can open it again, also where it has no name.
    std::filesystem::path path() const;
    /// Waits for the next bytes, from where the last read() ended, and sets how many came: 0 at the end.
    int read(std::span<std::byte> into, std::size_t& count) noexcept;
    /// Fills `into` from byte `offset` on. From several threads at once.
    int read_at(std::span<std::byte> into, std::uint64_t offset) const noexcept;
    int write_at(std::span<const std::byte> from, std::uint64_t offset) noexcept;
    /// Goes on where the last write() ended.
    int write(std::string_view text) noexcept;
    int truncate(std::uint64_t bytes) noexcept;
    /// Waits until all is on the disk.
    int sync() noexcept;
    /// Until it is closed; EWOULDBLOCK where another process has locked it. Whoever asks for no lock reads and writes on.
    int lock() noexcept;
    /// Some file systems report a full disk only here.
    int close() noexcept;
    /// The first bytes as a private mapping, which the array unmaps in the end, and has them read in.
    int map(std::size_t bytes, Array<std::byte>& into) const;

private:
    static constexpr std::intptr_t none = -1;
    std::intptr_t handle_ = none;
};

/// Of a file that is there, or of a folder, in which files are to be made.
int check_writable(const std::filesystem::path& path);

/// As std::fopen(path, "rb") does, which sets errno where it returns null.
std::FILE* open_stream(const std::filesystem::path& path);

/// Calls make(path) with paths of this beginning and end until one of them is not taken: until it does not return EEXIST.
int make_unique(const std::filesystem::path& prefix, std::string_view suffix, std::filesystem::path& made,
                FunctionRef<int(const std::filesystem::path&)> make);

}  // namespace lamella
