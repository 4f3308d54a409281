// What a call says whose library this build lacks.
#pragma once

#include <filesystem>
#include <string>

#include "lamella/error.hpp"

namespace lamella {

/// "cannot write 'a.h5': this build of lamella is without HDF5 (libhdf5-dev)". `verb`: write or read. Throws std::bad_alloc.
inline Error absent_format(const std::string& verb, const std::filesystem::path& path, const std::string& what) {
    return {.code = ErrorCode::invalid_argument,
            .message = "cannot " + verb + " '" + path.string() + "': this build of lamella is without " + what};
}

/// The same for a call that must not throw.
inline Error absent(const char* verb, const std::filesystem::path& path, const char* what) noexcept {
    try {
        return absent_format(verb, path, what);
    } catch (...) {
        return {ErrorCode::out_of_memory, "out of memory"};
    }
}

}  // namespace lamella
