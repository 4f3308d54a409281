#include "files/streams.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "lamella/io/text_file.hpp"
#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

constexpr const char* standard_input = "standard input";

Failure unreadable(int error_number) {
    return {bad_input, std::string(standard_input) + ": cannot be read: " + std::generic_category().message(error_number)};
}

Failure no_spool(int error_number) {
    return {bad_input, std::string(standard_input) + ": cannot be kept in a temporary file in '" + temporary_folder() +
                           "': " + std::generic_category().message(error_number)};
}

/// Removed as soon as it is open: whatever ends the process leaves nothing behind.
Descriptor open_unnamed() {
    // A file opened now would take the number of a standard input that is closed.
    if (::fcntl(STDIN_FILENO, F_GETFD) < 0) {
        throw unreadable(errno);
    }
    std::string name = (std::filesystem::path(temporary_folder()) / "lamella-XXXXXX").string();
    Descriptor file(::mkostemp(name.data(), O_CLOEXEC));
    if (file.number() < 0) {
        throw no_spool(errno);
    }
    ::unlink(name.c_str());
    return file;
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

}  // namespace

Descriptor::~Descriptor() {
    if (number_ >= 0) {
        ::close(number_);
    }
}

int write_all(const Descriptor& to, std::string_view bytes) noexcept {
    while (!bytes.empty()) {
        const ssize_t written = ::write(to.number(), bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) {
            return errno;
        }
        bytes.remove_prefix(static_cast<std::size_t>(written < 0 ? 0 : written));
    }
    return 0;
}

std::string input_name(const std::string& path) {
    return is_standard(path) ? standard_input : path;
}

std::string output_name(const std::string& path) {
    return is_standard(path) ? "standard output" : path;
}

std::string output_path(const std::string& path) {
    return is_standard(path) ? "/dev/stdout" : path;
}

void write_text(const std::string& path, const std::string& text) {
    if (is_standard(path)) {
        print(text);
    } else {
        done_or_thrown(write_text_file(path, text));
    }
}

std::string temporary_folder() {
    std::error_code unknown;
    const std::filesystem::path folder = std::filesystem::temp_directory_path(unknown);
    return unknown ? "/tmp" : folder.string();
}

SpooledInput::SpooledInput() : file_(open_unnamed()) {
    std::vector<char> buffer(std::size_t{1} << 20);
    while (const std::size_t count = read_some(buffer)) {
        if (const int error_number = write_all(file_, {buffer.data(), count}); error_number != 0) {
            throw no_spool(error_number);
        }
    }
}

}  // namespace lamella::cli
