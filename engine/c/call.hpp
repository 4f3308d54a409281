// What every call of lamella.h has in common: no exception leaves it, its error becomes a status and a message.
#pragma once

#include <memory>
#include <utility>

#include "base/guard.hpp"
#include "c/handles.hpp"

namespace lamella::c {

/// Writes what went wrong, or that nothing did, and returns the status.
std::int32_t report(const Status& status, lamella_error* error) noexcept;

/// Runs the body of a call.
template <class Body>
std::int32_t called(lamella_error* error, Body&& body) noexcept {
    return report(guarded(std::forward<Body>(body)), error);
}

/// Fills `*result`, or a new one that is put there once it is filled.
template <class Fill>
Status fill_result(lamella_result** result, const Fill& fill) {
    if (result == nullptr) {
        return Error{ErrorCode::invalid_argument, "there is nowhere to put the result: result is NULL"};
    }
    std::unique_ptr<lamella_result> fresh;
    if (*result == nullptr) {
        fresh = std::make_unique<lamella_result>();
    }
    Status status = fill(fresh != nullptr ? fresh->result : (*result)->result);
    if (status && fresh != nullptr) {
        *result = fresh.release();
    }
    return status;
}

/// Moves what a call of C++ gave into `*result`.
inline Status give_result(Result<SliceResult> given, lamella_result** result) {
    return fill_result(result, [&](SliceResult& filled) -> Status {
        if (!given) {
            return given.error();
        }
        filled = std::move(*given);
        return {};
    });
}

}  // namespace lamella::c
