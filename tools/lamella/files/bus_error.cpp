#include "files/bus_error.hpp"

#include <atomic>
#include <csignal>

#include <unistd.h>

#include "terminal/console.hpp"
#include "terminal/failure.hpp"

namespace lamella::cli {

namespace {

/// Made before it is needed: a handler may neither allocate nor format.
std::string& prepared_line() {
    static std::string line;
    return line;
}

/// Several threads may read the file: one says so, the others wait for the end.
extern "C" void end_with_prepared_line(int /*signal_number*/) {
    static std::atomic_flag taken;
    while (taken.test_and_set()) {
        ::pause();
    }
    const std::string& line = prepared_line();
    (void)!::write(STDERR_FILENO, line.data(), line.size());
    ::_exit(bad_input);
}

}  // namespace

void explain_bus_errors(const std::string& path) {
    prepared_line() = complaint(path + ": shrank while it was read, or its disk failed");
    (void)std::signal(SIGBUS, end_with_prepared_line);
}

}  // namespace lamella::cli
