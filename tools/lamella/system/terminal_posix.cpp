#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <utility>

#include <fcntl.h>
#include <glob.h>
#include <unistd.h>

#include "system/terminal.hpp"

namespace lamella::cli {

namespace {

/// Made before it is needed: a handler may neither allocate nor format.
struct BusError {
    std::string line;
    int exit_status = 0;
};
BusError& bus_error() {
    static BusError error;
    return error;
}

/// Several threads may read the file: one says so, the others wait for the end.
extern "C" void end_with_bus_error(int /*signal_number*/) {
    static std::atomic_flag taken;
    while (taken.test_and_set()) {
        ::pause();
    }
    write_error(bus_error().line);
    ::_exit(bus_error().exit_status);
}

}  // namespace

std::vector<std::string> begin_program(int count, char** words) {
    return count > 0 ? std::vector<std::string>(words + 1, words + count) : std::vector<std::string>();
}

bool is_terminal() {
    return ::isatty(STDERR_FILENO) == 1;
}

int check_standard_output() noexcept {
    const int flags = ::fcntl(STDOUT_FILENO, F_GETFL);
    return flags < 0 || (flags & O_ACCMODE) == O_RDONLY ? EBADF : 0;
}

void write_error(std::string_view text) noexcept {
    (void)!::write(STDERR_FILENO, text.data(), text.size());
}

void set_environment(const char* name, const std::string& value) {
    value.empty() ? ::unsetenv(name) : ::setenv(name, value.c_str(), 1);
}

void explain_bus_errors(std::string line, int exit_status) {
    bus_error() = {std::move(line), exit_status};
    (void)std::signal(SIGBUS, end_with_bus_error);
}

std::optional<std::vector<std::string>> expand_glob(const std::string& pattern) {
    glob_t found{};
    const std::unique_ptr<glob_t, void (*)(glob_t*)> owner(&found, &::globfree);
    const int status = ::glob(pattern.c_str(), GLOB_ERR, nullptr, &found);
    if (status != 0 && status != GLOB_NOMATCH) {
        return std::nullopt;
    }
    return std::vector<std::string>(found.gl_pathv, found.gl_pathv + found.gl_pathc);
}

}  // namespace lamella::cli
