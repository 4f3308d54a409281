#include "files/streams.hpp"

#include <cerrno>
#include <cstdlib>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "files/mesh_input.hpp"
#include "io/write/output_file.hpp"
#include "lamella/io/text_file.hpp"
#include "terminal/console.hpp"

namespace lamella::cli {

namespace {

Failure unreadable(int error_number) {
    return {bad_input, "standard input: cannot be read: " + std::generic_category().message(error_number)};
}

Failure no_spool(int error_number) {
    return {bad_input, "standard input: cannot be kept in a temporary file in '" + temporary_folder() +
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

Descriptor spooled_input() {
    Descriptor file = open_unnamed();
    std::vector<char> buffer(std::size_t{1} << 20);
    while (const std::size_t count = read_some(buffer)) {
        if (const int error_number = write_all(file, {buffer.data(), count}); error_number != 0) {
            throw no_spool(error_number);
        }
    }
    return file;
}

Failure unwritable(const std::string& path, int error_number) {
    return failure_of(lamella::unwritable(path, error_number));
}

void require_writable(const std::string& path) {
    if (is_standard(path)) {
        const int flags = ::fcntl(STDOUT_FILENO, F_GETFL);
        refuse_if(flags < 0 || (flags & O_ACCMODE) == O_RDONLY, bad_output,
                  "cannot write to standard output: " + std::generic_category().message(EBADF));
        return;
    }
    // Nothing is made for a trial: a signal at that moment would leave it behind.
    const std::filesystem::path file(path);
    std::error_code unknown;
    if (!file.has_filename() || std::filesystem::is_directory(file, unknown)) {
        throw unwritable(path, EISDIR);
    }
    const bool exists = std::filesystem::exists(file, unknown);
    const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
    if (!exists && std::filesystem::exists(folder, unknown) && !std::filesystem::is_directory(folder, unknown)) {
        throw unwritable(path, ENOTDIR);
    }
    if (::access(exists ? path.c_str() : folder.c_str(), exists ? W_OK : W_OK | X_OK) != 0) {
        throw unwritable(path, errno);
    }
}

void require_extension(const std::string& path, const std::string& option, const std::string& extension) {
    const std::string own = lower_case(std::filesystem::path(path).extension().string());
    std::error_code unknown;
    if (!own.empty() && own != extension && !std::filesystem::is_other(path, unknown)) {
        throw Failure(bad_usage,
                      option + ": '" + path + "': no format that is written ends in " + own + "; there is " + extension);
    }
}

std::string place_of(const std::string& path) {
    std::error_code unknown;
    const std::filesystem::path whole = std::filesystem::absolute(path, unknown);
    const std::filesystem::path place = std::filesystem::weakly_canonical(whole, unknown);
    return (unknown ? std::filesystem::path(path).lexically_normal() : place).string();
}

void FilePlan::require_free(const File& file) const {
    for (const File& other : files_) {
        const File& output = file.option.empty() ? other : file;
        const File& taken = file.option.empty() ? file : other;
        if (output.option.empty()) {
            continue;  // two inputs
        }
        std::error_code unknown;
        const bool one_stream = is_standard(output.path) && is_standard(taken.path);
        const bool no_stream = !is_standard(output.path) && !is_standard(taken.path);
        refuse_if(one_stream && !taken.option.empty(), bad_usage,
                  output.option + ": '-' is " + taken.what + " too, and standard output takes one of them");
        refuse_if(
            no_stream && (output.place == taken.place || std::filesystem::equivalent(output.path, taken.path, unknown)),
            bad_usage, output.option + ": '" + output.path + "' is " + taken.what + " itself");
    }
}

void FilePlan::add(const std::string& path, const std::string& option, const std::string& what) {
    if (!path.empty()) {
        const File file{path, place_of(path), option, what};
        require_free(file);
        files_.push_back(file);
    }
}

}  // namespace lamella::cli
