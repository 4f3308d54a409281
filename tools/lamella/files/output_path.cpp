#include "files/output_path.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "files/streams.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

Failure unwritable(const std::string& path, int error_number) {
    return {bad_output, "cannot write '" + path + "': " + std::generic_category().message(error_number)};
}

void require_open_output() {
    const int flags = ::fcntl(STDOUT_FILENO, F_GETFL);
    if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) {
        throw Failure(bad_output, "cannot write to standard output: " + std::generic_category().message(EBADF));
    }
}

}  // namespace

void require_writable(const std::string& path) {
    if (is_standard(path)) {
        require_open_output();
        return;
    }
    const std::filesystem::path file(path);
    std::error_code unknown;
    if (!file.has_filename() || std::filesystem::is_directory(file, unknown)) {
        throw unwritable(path, EISDIR);
    }
    if (std::filesystem::exists(file, unknown)) {
        if (::access(path.c_str(), W_OK) != 0) {
            throw unwritable(path, errno);
        }
        return;
    }
    const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
    if (::access(folder.c_str(), W_OK | X_OK) != 0) {
        throw unwritable(path, errno);
    }
    if (!std::filesystem::is_directory(folder, unknown)) {
        throw unwritable(path, ENOTDIR);
    }
}

void require_extension(const std::string& path, const std::string& option, const std::string& extension) {
    std::string own = std::filesystem::path(path).extension().string();
    std::transform(own.begin(), own.end(), own.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
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

void require_different(const std::string& path, const std::string& other, const std::string& name,
                       const std::string& other_name) {
    std::error_code unknown;
    if (!is_standard(path) && !is_standard(other) &&
        (place_of(path) == place_of(other) || std::filesystem::equivalent(path, other, unknown))) {
        throw Failure(bad_usage, name + ": '" + path + "' is " + other_name + " itself");
    }
}

void require_different_output(const std::string& path, const std::string& other, const std::string& name,
                              const std::string& other_name) {
    if (is_standard(path) && is_standard(other)) {
        throw Failure(bad_usage, name + ": '-' is " + other_name + " too, and standard output takes one of them");
    }
    require_different(path, other, name, other_name);
}

}  // namespace lamella::cli
