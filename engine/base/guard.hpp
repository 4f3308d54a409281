// Where exceptions end: what a public call does inside may throw, the call itself does not.
#pragma once

#include <utility>

#include "base/parallel.hpp"
#include "lamella/error.hpp"

namespace lamella {

/// Thrown where an input turns out to be refused only far inside a call.
struct Refused {
    Error error;
};

/// Throws Refused where a stage has refused the input; else gives what the stage does.
inline void require(const Status& status) {
    if (!status) {
        throw Refused{status.error()};
    }
}
template <class T>
T require(Result<T> result) {
    if (!result) {
        throw Refused{result.error()};
    }
    return std::move(result).value();
}

/// Returns what `call`, which works within `context`, returns, a Result or a Status, or the Error that its exception stands
/// for.
template <class Call>
auto guarded(const Context& context, Call&& call) noexcept -> decltype(call()) {
    try {
        if (context.threads < 0) {
            return Error{ErrorCode::invalid_argument, "threads must not be negative"};
        }
        return std::forward<Call>(call)();
    } catch (const Stopped&) {
        return Error{ErrorCode::cancelled, "cancelled"};
    } catch (Refused& refused) {
        return std::move(refused.error);
    } catch (...) {  // bad_alloc, or length_error where a text cannot be that long
        return Error{ErrorCode::out_of_memory, "out of memory"};  // short enough to need no memory
    }
}

template <class Call>
auto guarded(Call&& call) noexcept -> decltype(call()) {
    return guarded(Context{}, std::forward<Call>(call));
}

}  // namespace lamella
