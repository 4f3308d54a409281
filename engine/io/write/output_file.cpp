#include "io/write/output_file.hpp"

#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/text/text.hpp"
#include "lamella/io/name_text.hpp"
#include "lamella/io/text_file.hpp"

namespace lamella {

namespace {

constexpr int create_attempts = 100;

/// The descriptor of this process that the path stands for, or -1.
int descriptor_named(std::string_view path) noexcept {
    constexpr std::string_view numbered = "/dev/fd/";
    int number = -1;
    if (path.starts_with(numbered)) {
        return read_integer(path.substr(numbered.size()), number) ? number : -1;
    }
    return path == "/dev/stdout" ? STDOUT_FILENO : path == "/dev/stderr" ? STDERR_FILENO : -1;
}

/// The beginning of the names of this process's files aside of `destination`: hidden, and short enough for any name limit.
std::string aside_prefix(const std::filesystem::path& destination) {
    constexpr std::size_t longest_stem = 180;
    return "." + destination.filename().string().substr(0, longest_stem) + "." + std::to_string(::getpid()) + "-";
}

}  // namespace

Error unwritable(const std::filesystem::path& path, int error_number) {
    return {.code = ErrorCode::unwritable_file,
            .message = "cannot write '" + printable(path.native()) + "': " + std::generic_category().message(error_number)};
}

void remove_unfinished(const std::filesystem::path& path) noexcept {
    try {
        std::error_code ignored;
        const std::filesystem::path real = std::filesystem::canonical(path, ignored);
        const std::filesystem::path& destination = ignored ? path : real;
        const std::filesystem::path folder = destination.has_parent_path() ? destination.parent_path() : ".";
        const std::string prefix = aside_prefix(destination);
        std::filesystem::directory_iterator entry(folder, ignored);
        for (; entry != std::filesystem::directory_iterator(); entry.increment(ignored)) {
            if (entry->path().filename().string().starts_with(prefix)) {
                std::filesystem::remove(entry->path(), ignored);
            }
        }
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch): without memory the file stays, and the end goes on
    }
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
    if (descriptor_named(target.native()) >= 0) {
        OutputFile file(target, target);
        const int error_number = file.open_in_place();
        return error_number == 0 ? Result<OutputFile>(std::move(file)) : unwritable(target, error_number);
    }
    struct stat existing {};
    const bool exists = ::stat(target.c_str(), &existing) == 0;
    if (!exists && errno != ENOENT) {
        return unwritable(target, errno);
    }
    if (target.filename().empty() || (exists && S_ISDIR(existing.st_mode))) {
        return unwritable(target, EISDIR);
    }
    if (exists && ::access(target.c_str(), W_OK) != 0) {
        return unwritable(target, errno);
    }
    const bool in_place = exists && !S_ISREG(existing.st_mode);
    std::error_code unresolved;
    const std::filesystem::path real = std::filesystem::canonical(target, unresolved);
    OutputFile file(target, unresolved || in_place ? target : real);
    const int error_number = in_place ? file.open_in_place() : file.open_aside();
    if (error_number != 0) {
        return unwritable(target, error_number);
    }
    if (exists && !in_place) {
        (void)::fchmod(file.descriptor_, existing.st_mode & 07777);  // A file keeps its mode when it is replaced.
    }
    return file;
}

int OutputFile::open_in_place() noexcept {
    const int named = descriptor_named(destination_.native());
    descriptor_ = named >= 0 ? ::fcntl(named, F_DUPFD_CLOEXEC, 0) : ::open(destination_.c_str(), O_WRONLY | O_CLOEXEC);
    return descriptor_ < 0 ? errno : 0;
}

int OutputFile::open_aside() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    errno = EEXIST;
    for (int attempt = 0; attempt < create_attempts && descriptor_ < 0 && errno == EEXIST; ++attempt) {
        // Beside the target, so that the rename stays within one file system.
        aside_ = destination_.parent_path() / (aside_prefix(destination_) + std::to_string(now + attempt) + ".part");
        descriptor_ = ::open(aside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    }
    return descriptor_ < 0 ? errno : 0;
}

OutputFile::OutputFile(std::filesystem::path target, std::filesystem::path destination)
    : target_(std::move(target)), destination_(std::move(destination)), buffer_(new char[buffer_bytes]) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : target_(std::move(other.target_)),
      destination_(std::move(other.destination_)),
      aside_(std::move(other.aside_)),
      buffer_(std::move(other.buffer_)),
      used_(std::exchange(other.used_, 0)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      error_number_(other.error_number_) {}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0) {
        ::close(descriptor_);
        if (!aside_.empty()) {
            ::unlink(aside_.c_str());
        }
    }
}

char* OutputFile::room(std::size_t bytes) {
    assert(bytes <= buffer_bytes);
    if (buffer_bytes - used_ < bytes) {
        flush();
    }
    return buffer_.get() + used_;
}

void OutputFile::advance(const char* end) noexcept {
    used_ = static_cast<std::size_t>(end - buffer_.get());
    assert(used_ <= buffer_bytes);
}

void OutputFile::append(std::string_view text) {
    if (text.empty()) {  // and its place may be null
        return;
    }
    if (text.size() > buffer_bytes) {
        flush();
        write_out(text.data(), text.size());
        return;
    }
    char* const to = room(text.size());
    std::memcpy(to, text.data(), text.size());
    advance(to + text.size());
}

void OutputFile::write_out(const char* from, std::size_t bytes) noexcept {
    while (bytes > 0 && error_number_ == 0) {
        const ssize_t written = ::write(descriptor_, from, bytes);
        if (written >= 0) {
            from += written;
            bytes -= static_cast<std::size_t>(written);
        } else if (errno != EINTR) {
            error_number_ = errno;
        }
    }
}

void OutputFile::flush() noexcept {
    write_out(buffer_.get(), used_);
    used_ = 0;
}

Status OutputFile::commit() {
    assert(descriptor_ >= 0);
    flush();
    // Some file systems report a full disk only on closing.
    if (::close(std::exchange(descriptor_, -1)) != 0 && error_number_ == 0) {
        error_number_ = errno;
    }
    if (aside_.empty()) {
        return error_number_ == 0 ? Status() : unwritable(target_, error_number_);
    }
    if (error_number_ == 0 && ::rename(aside_.c_str(), destination_.c_str()) != 0) {
        error_number_ = errno;
    }
    if (error_number_ != 0) {
        ::unlink(aside_.c_str());
        return unwritable(target_, error_number_);
    }
    return {};
}

Status write_text_file(const std::filesystem::path& path, const std::string& text) noexcept {
    return guarded([&]() -> Status {
        OutputFile file = require(OutputFile::create(path));
        file.append(text);
        return file.commit();
    });
}

}  // namespace lamella
