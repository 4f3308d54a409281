// HDF5's identifiers as values, and its errors as exceptions.
#pragma once

#include <utility>

#include <hdf5.h>

#include "base/guard.hpp"

namespace lamella {

/// While it lives, HDF5 prints nothing of its errors in this thread.
class QuietErrors {
public:
    QuietErrors() noexcept;
    ~QuietErrors();
    QuietErrors(const QuietErrors&) = delete;
    QuietErrors& operator=(const QuietErrors&) = delete;

private:
    H5E_auto2_t print_ = nullptr;
    void* context_ = nullptr;
    bool known_ = false;
};

/// What HDF5 says of its last failure, on one line; empty where it says nothing.
std::string hdf5_words();

/// Of a call that only fails for want of memory.
Refused hdf5_failure();

inline void checked(herr_t status) {
    if (status < 0) {
        throw hdf5_failure();
    }
}

/// Owns an identifier.
class Handle {
public:
    Handle() = default;
    /// Throws hdf5_failure() where there is none.
    Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
        if (id < 0) {
            throw hdf5_failure();
        }
    }
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle() {
        if (id_ >= 0) {
            close_(id_);
        }
    }

    hid_t id() const noexcept { return id_; }

private:
    hid_t id_ = -1;
    herr_t (*close_)(hid_t) = nullptr;
};

}  // namespace lamella
