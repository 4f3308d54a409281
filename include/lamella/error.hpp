// Errors as values: every call that can fail returns a Result or a Status.
//
//     const lamella::Result<lamella::SliceResult> sliced = lamella::slice(mesh);
//     if (!sliced) {
//         const lamella::Error& error = sliced.error();
//         std::fprintf(stderr, "%s\n", error.message.c_str());
//         if (error.code == lamella::ErrorCode::bad_coordinate) {
//             std::fprintf(stderr, "look at triangle %lld\n", static_cast<long long>(error.triangle));
//         }
//         return;
//     }
//     std::printf("%zu layers\n", sliced->layers.size());
//
// The library never throws across its interface, prints, aborts or exits. What went wrong is one line of text for a person,
// and the evidence as data for a program.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace lamella {

enum class ErrorCode : std::uint8_t {
    invalid_argument,  ///< an option that contradicts itself or lies outside its range
    unreadable_file,   ///< missing, a directory, no permission, or it changed while it was read
    malformed_mesh,    ///< the bytes are not a mesh in the format that they claim
    empty_mesh,        ///< no triangle at all, or none with three distinct corners on the grid
    bad_coordinate,    ///< a coordinate that is not finite, or beyond 1e9 mm
    bad_planes,        ///< a height that is not finite, planes that are one on the grid, a step under two units, too many
    result_too_large,  ///< the result is known to exceed the memory limit; nothing was allocated for it
    out_of_memory,     ///< an allocation failed
    cancelled,         ///< the host's Context::stop said so
    unwritable_file,   ///< the output could not be created or written
};

/// What went wrong, as one line for a person (it names file and place where there are any) and as data for a program.
struct Error {
    ErrorCode code = ErrorCode::invalid_argument;
    std::string message;
    std::int64_t triangle = -1;     ///< index of the offending triangle in the input, or -1
    std::int64_t plane = -1;        ///< index of the offending plane, or -1
    std::int64_t byte_offset = -1;  ///< where in the file, or -1
    std::int64_t part = -1;         ///< index of the offending part, where there are several, or -1
};

/// Either a value or an Error. `Result<void>` is spelled `Status`.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : value_(std::move(value)) {}      // NOLINT(google-explicit-constructor): `return value;` reads best
    Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

    explicit operator bool() const noexcept { return value_.has_value(); }
    bool ok() const noexcept { return value_.has_value(); }

    /// Precondition of value access: ok(). A temporary gives its value away, so that `for (... : *slice(mesh))` is safe.
    T& value() & { return *value_; }
    const T& value() const& { return *value_; }
    T value() && { return std::move(*value_); }
    T& operator*() & { return *value_; }
    const T& operator*() const& { return *value_; }
    T operator*() && { return std::move(*value_); }
    T* operator->() & { return &*value_; }
    const T* operator->() const& { return &*value_; }
    const T* operator->() const&& = delete;  // name the Result: its value ends with it

    /// Precondition: not ok().
    const Error& error() const& { return error_; }
    Error error() && { return std::move(error_); }

private:
    std::optional<T> value_;
    Error error_;
};

/// Success, or an Error.
class [[nodiscard]] Status {
public:
    Status() = default;
    Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

    explicit operator bool() const noexcept { return !error_.has_value(); }
    bool ok() const noexcept { return !error_.has_value(); }
    const Error& error() const& { return *error_; }
    Error error() && { return *std::move(error_); }

private:
    std::optional<Error> error_;
};

}  // namespace lamella
