#include "files/standard_streams.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

constexpr const char* standard_input = "standard input";

std::string reason(int error_number) {
    return std::generic_category().message(error_number);
}

Failure unreadable(int error_number) {
    return {bad_input, std::string(standard_input) + ": cannot be read: " + reason(error_number)};
}

Failure no_spool(const std::filesystem::path& folder, int error_number) {
    return {bad_input, std::string(standard_input) + ": cannot be kept in a temporary file in '" + folder.string() +
                           "': " + reason(error_number)};
}

std::filesystem::path temporary_folder() {
    std::error_code unknown;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(unknown);
    return unknown ? "/tmp" : folder;
}

/// Removed as soon as it is open: whatever ends the process leaves nothing behind.
int open_unnamed(const std::filesystem::path& folder) {
    std::string name = (folder / "lamella-XXXXXX").string();
    const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0) {
        throw no_spool(folder, errno);
    }
    ::unlink(name.c_str());
    return descriptor;
}

/// 0 at the end.
std::size_t read_some(std::vector<char>& buffer) {
    for (;;) {
        const ssize_t got = ::read(STDIN_FILENO, buffer.data(), buffer.size());
        if (got >= 0) {
            return static_cast<std::size_t>(got);
        }
        if (errno == EAGAIN) {
            pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
            (void)::poll(&input, 1, -1);
        } else if (errno != EINTR) {
            throw unreadable(errno);
        }
    }
}

/// 0 or an errno.
int write_all(int descriptor, const char* from, std::size_t count) {
    while (count > 0) {
        const ssize_t written = ::write(descriptor, from, count);
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        if (written > 0) {
            from += written;
            count -= static_cast<std::size_t>(written);
        }
    }
    return 0;
}

}  // namespace

std::string input_name(const std::string& path) {
    return is_standard(path) ? standard_input : path;
}

std::string output_name(const std::string& path) {
    return is_standard(path) ? "standard output" : path;
}

std::string output_path(const std::string& path) {
    return is_standard(path) ? "/dev/stdout" : path;
}

SpooledInput::SpooledInput() {
    // A file opened now would take the number of a standard input that is closed.
    if (::fcntl(STDIN_FILENO, F_GETFD) < 0) {
        throw unreadable(errno);
    }
    constexpr std::size_t buffer_bytes = std::size_t{1} << 20;
    std::vector<char> buffer(buffer_bytes);
    const std::filesystem::path folder = temporary_folder();
    descriptor_ = open_unnamed(folder);
    try {
        while (const std::size_t count = read_some(buffer)) {
            if (const int error_number = write_all(descriptor_, buffer.data(), count); error_number != 0) {
                throw no_spool(folder, error_number);
            }
        }
    } catch (const Failure&) {
        ::close(descriptor_);
        throw;
    }
}

SpooledInput::~SpooledInput() {
    ::close(descriptor_);
}

}  // namespace lamella::cli
