// How a command fails: one line for a person and an exit status for a script.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "lamella/error.hpp"

namespace lamella::cli {

enum ExitStatus : int {
    done = 0,
    bad_usage = 2,
    bad_input = 3,
    bad_output = 4,
    some_failed = 5,  ///< items of a batch, or outputs that differ from their records
};

class Failure : public std::runtime_error {
public:
    Failure(ExitStatus status, const std::string& line) : std::runtime_error(line), status_(status) {}
    ExitStatus status() const noexcept { return status_; }

private:
    ExitStatus status_;
};

/// The exit status and line for an error of the library.
inline Failure failure_of(const Error& error) {
    switch (error.code) {
        case ErrorCode::invalid_argument:
        case ErrorCode::bad_planes:
        case ErrorCode::result_too_large:
            return {bad_usage, error.message};
        case ErrorCode::unwritable_file:
            return {bad_output, error.message};
        case ErrorCode::unreadable_file:
        case ErrorCode::malformed_mesh:
        case ErrorCode::empty_mesh:
        case ErrorCode::bad_coordinate:
        case ErrorCode::out_of_memory:
        case ErrorCode::cancelled:
            break;
    }
    return {bad_input, error.message};
}

/// The value that the library made. Throws Failure where it made none.
template <class T>
T done_or_thrown(Result<T> result) {
    if (!result) {
        throw failure_of(result.error());
    }
    return std::move(result).value();
}

/// The same for a mesh: a line on what is wrong with it names it; one on an option says all.
template <class T>
T done_or_thrown(Result<T> result, const std::string& mesh) {
    if (!result) {
        const Failure failure = failure_of(result.error());
        throw failure.status() == bad_input ? Failure(bad_input, mesh + ": " + failure.what()) : failure;
    }
    return std::move(result).value();
}

inline void done_or_thrown(const Status& status) {
    if (!status) {
        throw failure_of(status.error());
    }
}

}  // namespace lamella::cli
