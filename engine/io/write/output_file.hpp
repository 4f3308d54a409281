// A file that appears whole or not at all: written aside under a unique name, renamed into place when complete.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string_view>

#include "base/guard.hpp"
#include "base/system/file.hpp"
#include "lamella/error.hpp"

namespace lamella {

/// Move-only. Whatever ends before commit() leaves no trace. A target that is no regular file (a device, a pipe) cannot be
/// renamed onto and is written in place. /dev/stdout, /dev/stderr and /dev/fd/N are this process's open descriptors,
/// wherever they lead: opened by these paths, a file would be written from its begin again, and a socket not at all. Errors
/// stick: the first is kept, later output is dropped, commit() reports it.
class OutputFile {
public:
    /// Largest request that room() serves.
    static constexpr std::size_t buffer_bytes = std::size_t{1} << 20;

    /// Creates the file aside. Errors: unwritable_file. Throws std::bad_alloc.
    static Result<OutputFile> create(const std::filesystem::path& target);

    OutputFile(OutputFile&&) noexcept = default;
    OutputFile& operator=(OutputFile&&) = delete;
    ~OutputFile();

    /// Space for `bytes` at the end of what is written; advance() must follow with how much of it was used.
    char* room(std::size_t bytes);
    void advance(const char* end) noexcept;

    void append(std::string_view text);

    /// Something could not be written: what follows is for nothing.
    bool failed() const noexcept { return error_number_ != 0; }

    /// Writes what is left and puts the file in its place; `durable`: on disk when this returns. Errors: unwritable_file.
    Status commit(bool durable = false);

private:
    OutputFile(std::filesystem::path target, std::filesystem::path destination);
    int open_in_place();  ///< these two give an error number, or 0
    int open_aside();
    void write_out(std::string_view text) noexcept;
    void flush() noexcept;

    std::filesystem::path target_;       ///< as the caller named it, for messages
    std::filesystem::path destination_;  ///< where links lead
    std::filesystem::path aside_;        ///< empty when the target is written in place
    std::unique_ptr<char[]> buffer_;
    std::size_t used_ = 0;
    File file_;
    int error_number_ = 0;
};

/// A file that is written by calls which do not throw: the first error is kept, and finish() returns it.
struct OutputStream {
    OutputFile out;
    Status done{};

    template <class Step>
    void attempt(const Step& step) noexcept {
        if (done) {
            done = guarded([&]() -> Status {
                step();
                return {};
            });
        }
    }
    bool failed() const noexcept { return !done || out.failed(); }
    Status finish() noexcept {
        return done ? guarded([&] { return out.commit(); }) : done;
    }
};

/// "cannot write 'PATH': REASON"
Error unwritable(const std::filesystem::path& path, int error_number);

}  // namespace lamella
