#include <cerrno>

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/system/file.hpp"

namespace lamella {

namespace {

int error_where(bool failed) noexcept {
    return failed ? errno : 0;
}

std::filesystem::file_type type_of(mode_t mode) noexcept {
    using Type = std::filesystem::file_type;
    return S_ISREG(mode)    ? Type::regular
           : S_ISDIR(mode)  ? Type::directory
           : S_ISFIFO(mode) ? Type::fifo
           : S_ISSOCK(mode) ? Type::socket
                            : Type::character;
}

FileStatus status_of(const struct stat& found) noexcept {
#ifdef __APPLE__
    const timespec changed = found.st_mtimespec;
#else
    const timespec changed = found.st_mtim;
#endif
    constexpr std::uint64_t nanoseconds = 1'000'000'000;
    return {type_of(found.st_mode), static_cast<std::uint64_t>(found.st_size),
            static_cast<std::uint64_t>(changed.tv_sec) * nanoseconds + static_cast<std::uint64_t>(changed.tv_nsec),
            static_cast<std::uint64_t>(found.st_dev), static_cast<std::uint64_t>(found.st_ino)};
}

/// Calls step(bytes done so far), which gives how many more are, until all are. What a signal interrupts is tried again.
template <class Step>
int in_steps(std::size_t bytes, int none_done, const Step& step) noexcept {
    for (std::size_t done = 0; done < bytes;) {
        const ssize_t more = step(done);
        if (more == 0 || (more < 0 && errno != EINTR)) {
            return more == 0 ? none_done : errno;
        }
        done += static_cast<std::size_t>(more > 0 ? more : 0);
    }
    return 0;
}

/// Lets an Array own a mapping: it takes address space, over which the file is then mapped. Pages are aligned enough.
constexpr Memory mapped_memory = {
    {nullptr,
     [](void*, std::size_t bytes, std::size_t) noexcept -> void* {
         void* const memory = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
         return memory == MAP_FAILED ? nullptr : memory;
     }},
    {nullptr, [](void*, void* memory, std::size_t bytes, std::size_t) noexcept { ::munmap(memory, bytes); }}};

}  // namespace

std::string system_message(int error_number) {
    return std::generic_category().message(error_number);
}

std::string path_text(const std::filesystem::path& path) {
    return path.native();
}

std::filesystem::path system_path(const std::filesystem::path& path) {
    return path;
}

bool can_list(const std::filesystem::path& /*folder*/) {
    return true;
}

int File::open_to_read(const std::filesystem::path& path) {
    handle_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    return error_where(!is_open());
}

int File::open_to_write(const std::filesystem::path& path) {
    handle_ = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    return error_where(!is_open());
}

int File::create(const std::filesystem::path& path, unsigned mode) {
    handle_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, static_cast<mode_t>(mode));
    return error_where(!is_open());
}

int File::open_or_create(const std::filesystem::path& path, unsigned mode) {
    handle_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, static_cast<mode_t>(mode));
    return error_where(!is_open());
}

int File::create_scratch(const std::filesystem::path& folder) {
    std::filesystem::path path;
    const int failure = create_unique(folder / ".lamella-", {}, 0600, path);
    return failure == 0 ? error_where(::unlink(path.c_str()) != 0) : failure;
}

int File::duplicate(int number) noexcept {
    handle_ = ::fcntl(number, F_DUPFD_CLOEXEC, 0);
    return error_where(!is_open());
}

int status_of(const std::filesystem::path& path, FileStatus& status) {
    struct stat found {};
    const bool failed = ::stat(path.c_str(), &found) != 0;
    status = status_of(found);
    return error_where(failed);
}

int File::status(FileStatus& status) const noexcept {
    struct stat found {};
    const bool failed = ::fstat(static_cast<int>(handle_), &found) != 0;
    status = status_of(found);
    return error_where(failed);
}

std::filesystem::path File::path() const {
    return "/dev/fd/" + std::to_string(handle_);
}

int File::read(std::span<std::byte> into, std::size_t& count) noexcept {
    const int number = static_cast<int>(handle_);
    ssize_t got = 0;
    while ((got = ::read(number, into.data(), into.size())) < 0 && (errno == EINTR || errno == EAGAIN)) {
        pollfd input{.fd = number, .events = POLLIN, .revents = 0};
        (void)::poll(&input, 1, errno == EAGAIN ? -1 : 0);
    }
    count = got > 0 ? static_cast<std::size_t>(got) : 0;
    return error_where(got < 0);
}

int File::read_at(std::span<std::byte> into, std::uint64_t offset) const noexcept {
    return in_steps(into.size(), ended, [&](std::size_t done) {
        return ::pread(static_cast<int>(handle_), into.data() + done, into.size() - done, static_cast<off_t>(offset + done));
    });
}

int File::write_at(std::span<const std::byte> from, std::uint64_t offset) noexcept {
    return in_steps(from.size(), EIO, [&](std::size_t done) {
        return ::pwrite(static_cast<int>(handle_), from.data() + done, from.size() - done,
                        static_cast<off_t>(offset + done));
    });
}

int File::write(std::string_view text) noexcept {
    return in_steps(text.size(), EIO, [&](std::size_t done) {
        return ::write(static_cast<int>(handle_), text.data() + done, text.size() - done);
    });
}

int File::truncate(std::uint64_t bytes) noexcept {
    return error_where(::ftruncate(static_cast<int>(handle_), static_cast<off_t>(bytes)) != 0);
}

int File::sync() noexcept {
    return error_where(::fsync(static_cast<int>(handle_)) != 0);
}

int File::lock() noexcept {
    return error_where(::flock(static_cast<int>(handle_), LOCK_EX | LOCK_NB) != 0);
}

int File::close() noexcept {
    return is_open() ? error_where(::close(static_cast<int>(std::exchange(handle_, none))) != 0) : 0;
}

int File::map(std::size_t bytes, Array<std::byte>& into) const {
    into = Array<std::byte>(&mapped_memory);
    into.resize_discarding(bytes);
    constexpr int over_it = MAP_PRIVATE | MAP_FIXED;
    if (::mmap(into.data(), bytes, PROT_READ | PROT_WRITE, over_it, static_cast<int>(handle_), 0) == MAP_FAILED) {
        return errno;
    }
    (void)::madvise(into.data(), bytes, MADV_WILLNEED);  // advice only
    return 0;
}

int check_writable(const std::filesystem::path& path) {
    std::error_code unknown;
    const int searched = std::filesystem::is_directory(path, unknown) ? X_OK : 0;
    return error_where(::access(path.c_str(), W_OK | searched) != 0);
}

std::FILE* open_stream(const std::filesystem::path& path) {
    return std::fopen(path.c_str(), "rb");
}

}  // namespace lamella
