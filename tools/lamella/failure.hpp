// How a command fails: one line for a person and an exit status for a script.
#pragma once

#include <stdexcept>
#include <string>

#include "lamella/status.hpp"

namespace lamella::cli {

enum ExitStatus : int {
    done = 0,
    bad_usage = 2,
    bad_input = 3,
    bad_output = 4,
};

class Failure : public std::runtime_error {
public:
    Failure(ExitStatus status, const std::string& line) : std::runtime_error(line), status_(status) {}
    ExitStatus status() const noexcept { return status_; }

private:
    ExitStatus status_;
};

/// What the library's error means for a command line.
inline Failure failure_of(const Error& error) {
    switch (error.code) {
        case Code::invalid_argument:
        case Code::bad_planes:
        case Code::result_too_large:
            return {bad_usage, error.message};
        case Code::unwritable_file:
            return {bad_output, error.message};
        case Code::unreadable_file:
        case Code::malformed_mesh:
        case Code::empty_mesh:
        case Code::bad_coordinate:
        case Code::too_entangled:
        case Code::out_of_memory:
        case Code::cancelled:
            break;
    }
    return {bad_input, error.message};
}

}  // namespace lamella::cli
